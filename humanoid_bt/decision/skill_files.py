"""Loading skills from a workspace's files, the built-in ones and the user's alike.

A file is run under a private module name made from its path, so that no skill file ever stands in for another
module, whatever it is called.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import re
import sys
import traceback
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Dummy

from humanoid_bt.core.ctrl_c import is_ctrl_c
from humanoid_bt.core.errors import Place, Problem, UserError, nearest, relative, resolved
from humanoid_bt.core.messages import RESOURCES
from humanoid_bt.core.params import params_of
from humanoid_bt.decision.result import declared_results
from humanoid_bt.decision.skill import Skill, node_type_name
from humanoid_bt.files.reading import read_text
from humanoid_bt.files.workspace import Workspace

_SOURCE = "__humanoid_bt_source__"
_TAKEN = frozenset((*dir(Dummy("node")), *dir(Skill), "path", "robot", "halt_reason"))
"""Attributes that a node has already; a parameter of that name would break it."""


_IMPORTED_FROM = re.compile(r" \([^()]*\)$")
"""Where a module that lacks a name is, in the message of an ImportError."""
_NO_NAME = re.compile(r"cannot import name '(\w+)'")


@dataclass(frozen=True)
class _Found:
    cls: type[Behaviour]
    folder: Path
    place: Place


def load_skills(workspace: Workspace) -> dict[str, type[Behaviour]]:
    """Return every skill of a workspace by its name in tree files; the user's win over built-in ones.

    A skill is a class defined in the file that is a :class:`~humanoid_bt.decision.skill.Skill` or a plain py_trees
    behaviour; abstract classes that others build on and names with a leading underscore are left out.

    Raises:
        UserError: with every problem found: a file that cannot be imported, a name that two files of one folder
            declare, a declaration that is not valid.
    """
    found: dict[str, _Found] = {}
    problems: list[Problem] = []
    for path in workspace.skill_files():
        try:
            module = _module(path)
        except UserError as error:
            problems += error.problems
            continue
        for cls in _behaviours(module):
            name, place = node_type_name(cls), class_place(cls)
            known = found.get(name)
            if known and known.folder == path.parent:
                hint = f"first at {known.place}"
                problems.append(Problem(f"the skill {name!r} is declared twice", place, hint, code="duplicate-skill"))
            problems += _mistakes(name, cls, place)
            found[name] = _Found(cls, path.parent, place)
    if problems:
        raise UserError(problems)
    return {name: skill.cls for name, skill in sorted(found.items())}


def class_place(cls: type) -> Place:
    """Return where a skill's class is written."""
    path = class_file(cls)
    file = relative(path) if path else cls.__module__
    source = getattr(sys.modules.get(cls.__module__), _SOURCE, "")
    for number, line in enumerate(source.splitlines(), 1):
        words = line.replace("(", " ").replace(":", " ").split()
        if words[:2] == ["class", cls.__name__]:
            return Place(file, number, line.index("class") + 1)
    return Place(file)


def class_file(cls: type) -> Path | None:
    """Return the file that a class is written in, None if it is not known."""
    file = getattr(sys.modules.get(cls.__module__), "__file__", None)
    return Path(file) if file else None


def place_in_file(error: BaseException, file: Path) -> Place | None:
    """Return the innermost line of a file that an exception passed through, None if it did not."""
    if isinstance(error, SyntaxError) and error.filename == str(file):
        return Place(relative(file), error.lineno or 1, error.offset or 1)
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        if frame.filename == str(file):
            return Place(relative(file), frame.lineno or 1, (frame.colno or 0) + 1)
    return None


def _module(path: Path) -> ModuleType:
    source = read_text(path)
    path = resolved(path)
    name = f"_humanoid_bt_skill_{hashlib.sha256(os.fsencode(path)).hexdigest()[:16]}_{path.stem}"
    known = sys.modules.get(name)
    if known is not None and getattr(known, _SOURCE, None) == source:
        return known
    module = ModuleType(name)
    module.__file__ = str(path)
    setattr(module, _SOURCE, source)
    sys.modules[name] = module  # type hints and dataclasses look their module up there
    try:
        # compiled here, not by the import system: no cache files in people's folders, and never a stale one
        exec(compile(source, str(path), "exec", dont_inherit=True), vars(module))
    except BaseException as error:
        if is_ctrl_c(error):
            raise
        if known is None:
            del sys.modules[name]
        else:
            sys.modules[name] = known  # a tree that runs goes on with it
        message = error.msg if isinstance(error, SyntaxError) else _IMPORTED_FROM.sub("", str(error))
        raise UserError(
            f"the skill file cannot be imported: {type(error).__name__}: {message}",
            place_in_file(error, path) or Place(relative(path)),
            _meant(error),
            code="broken-skill",
        ) from error
    return module


def _meant(error: BaseException) -> str:
    """Return a hint on a name that a module does not have, or that nothing has."""
    name = _NO_NAME.search(str(error))
    if isinstance(error, ImportError) and name and error.name in sys.modules:
        module = sys.modules[error.name]
        return nearest(name[1], getattr(module, "__all__", dir(module)))
    if isinstance(error, NameError) and error.name:
        here = sys.modules[__package__.partition(".")[0]]
        if error.name in here.__all__:
            return f"from {here.__name__} import {error.name}"
        return nearest(error.name, here.__all__)
    return ""


def _behaviours(module: ModuleType) -> list[type[Behaviour]]:
    return [
        cls
        for cls in dict.fromkeys(value for value in vars(module).values() if isinstance(value, type))
        if issubclass(cls, Behaviour)
        and cls.__module__ == module.__name__
        and not _is_base(cls)
        and not cls.__name__.startswith("_")
    ]


def _is_base(cls: type) -> bool:
    """Return whether a class is there for others to build on: it is abstract, and some do."""
    return inspect.isabstract(cls) and bool(cls.__subclasses__())


def _mistakes(name: str, cls: type[Behaviour], place: Place) -> list[Problem]:
    problems: list[Problem] = []
    missing = sorted(getattr(cls, "__abstractmethods__", ()))
    if missing:
        hint = f"def {missing[0]}(self) -> ..., or a leading underscore if it is no skill"
        message = f"the skill {name!r} has no {'(), '.join(missing)}()"
        problems.append(Problem(message, place, hint, code="broken-skill"))
    resources = getattr(cls, "resources", ())
    if not isinstance(resources, tuple):
        message = f"the resources of {name!r} must be a tuple"
        problems.append(Problem(message, place, 'resources = ("base",)', code="broken-skill"))
    else:
        valid = f"valid: {', '.join(RESOURCES)}"
        problems += [
            Problem(f"{name!r} declares an unknown resource {resource!r}", place, valid, code="unknown-resource")
            for resource in resources
            if resource not in RESOURCES
        ]
    try:
        declared = params_of(cls)
    except (NameError, KeyError, TypeError) as error:
        message = f"the parameters of {name!r} cannot be read: {error}"
        problems.append(Problem(message, place, "annotate each of them", code="broken-skill"))
    else:
        for parameter in declared:
            if parameter in _TAKEN:
                message = f"{name!r} declares the parameter {parameter!r}, which every node has already"
                problems.append(Problem(message, place, "rename it", code="taken-name"))
        problems += _wrong_results(name, cls, place, declared)
    return problems


def _wrong_results(name: str, cls: type[Behaviour], place: Place, parameters: Iterable[str]) -> Iterator[Problem]:
    for declared in declared_results(cls).values():
        if declared.name in _TAKEN or declared.name in parameters:
            whose = "every node" if declared.name in _TAKEN else "it"
            what = "already" if declared.name in _TAKEN else "as a parameter, too"
            message = f"{name!r} declares the result {declared.name!r}, which {whose} has {what}"
            yield Problem(message, place, "rename it", code="taken-name")
        try:
            _ = declared.type
        except (NameError, TypeError) as error:
            yield Problem(f"in {name!r}: {error}", place, "annotate it", code="broken-skill")
    if declared_results(cls) and not issubclass(cls, Skill):
        message = f"{name!r} declares results and is no Skill"
        yield Problem(message, place, f"class {cls.__name__}(Skill)", code="broken-skill")
