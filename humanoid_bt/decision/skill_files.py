"""Loading skills from a workspace's files, the built-in ones and the user's alike."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from py_trees.behaviour import Behaviour
from py_trees.behaviours import Dummy

from humanoid_bt.core.declared import wrong_parameters
from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.messages import RESOURCES
from humanoid_bt.core.params import params_of
from humanoid_bt.decision.overridden import not_makeable
from humanoid_bt.decision.result import declared_results
from humanoid_bt.decision.skill import Skill, node_type_name
from humanoid_bt.files.class_files import class_place, classes_of, load_module
from humanoid_bt.files.workspace import Workspace

_TAKEN = frozenset((*dir(Dummy("node")), *dir(Skill), "path", "robot", "halt_reason"))
"""Attributes that a node has already; a parameter of that name would break it."""


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
            module = load_module(path, "skill")
        except UserError as error:
            problems += error.problems
            continue
        for cls in classes_of(module, Behaviour):
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
        problems += wrong_parameters(name, declared, place, "broken-skill")
        problems += filter(None, [not_makeable(cls, declared)])
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
