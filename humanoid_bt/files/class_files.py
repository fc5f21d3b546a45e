"""Loading classes from Python files: skills, percept sources and bodies, the built-in ones and the user's alike.

A file is run under a private module name made from its path, so that no such file ever stands in for another module,
whatever it is called.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import re
import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any, Literal

from humanoid_bt.core.ctrl_c import is_ctrl_c
from humanoid_bt.core.errors import Place, UserError, nearest, relative, resolved
from humanoid_bt.core.texts import meant, told
from humanoid_bt.files.reading import read_text

What = Literal["skill", "source", "body"]

_SOURCE = "__humanoid_bt_source__"
_NOUNS: dict[What, str] = {"skill": "skill file", "source": "file of percept sources", "body": "file of a body"}

_IMPORTED_FROM = re.compile(r" \([^()]*\)$")
"""Where a module that lacks a name is, in the message of an ImportError."""
_NO_NAME = re.compile(r"cannot import name '(\w+)'")


def load_module(path: Path, what: What) -> ModuleType:
    """Run a file, unless that was done before and its text is still the same; return what it defines.

    Args:
        path: the file.
        what: what is in it.

    Raises:
        UserError: it cannot be imported.
    """
    source = read_text(path)
    path = resolved(path)
    name = f"_humanoid_bt_{what}_{hashlib.sha256(os.fsencode(path)).hexdigest()[:16]}_{path.stem}"
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
            sys.modules[name] = known  # what runs goes on with it
        message = error.msg if isinstance(error, SyntaxError) else _IMPORTED_FROM.sub("", str(error))
        raise UserError(
            f"the {_NOUNS[what]} cannot be imported: {type(error).__name__}: {message}",
            place_in_file(error, path) or Place(relative(path)),
            _meant(error),
            code=f"broken-{what}",
        ) from error
    return module


def classes_of(module: ModuleType, base: type) -> list[type[Any]]:
    """Return the classes of a kind that a file defines; those that others build on and private ones are left out."""
    return [
        cls
        for cls in dict.fromkeys(value for value in vars(module).values() if isinstance(value, type))
        if issubclass(cls, base)
        and cls.__module__ == module.__name__
        and not _is_base(cls)
        and not cls.__name__.startswith("_")
    ]


def class_place(cls: type) -> Place:
    """Return where a class is written."""
    path = class_file(cls)
    file = relative(path) if path else cls.__module__
    source = getattr(sys.modules.get(cls.__module__), _SOURCE, "")
    for number, line in enumerate(source.splitlines(), 1):
        words = line.replace("(", " ").replace(":", " ").split()
        if words[:2] == ["class", cls.__name__]:
            return Place(file, number, line.index("class") + 1)
    return Place(file)


def method_place(cls: type, name: str) -> Place:
    """Return where a method of a class begins; where the class is written if that is not known."""
    method: Any = vars(cls).get(name)
    code = getattr(inspect.unwrap(method), "__code__", None)
    path = class_file(cls)
    if code is None or path is None or code.co_filename != str(path):
        return class_place(cls)
    lines = getattr(sys.modules.get(cls.__module__), _SOURCE, "").splitlines()
    line = lines[code.co_firstlineno - 1] if code.co_firstlineno <= len(lines) else ""
    return Place(relative(path), code.co_firstlineno, len(line) - len(line.lstrip()) + 1)


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


def why_raised(error: BaseException, cls: type) -> str:
    """Return what a class's code raised, and at which of its own lines if it was there."""
    file = class_file(cls)
    place = place_in_file(error, file) if file else None
    return told(error) + (f", raised at {place}" if place else "")


def _is_base(cls: type) -> bool:
    """Return whether a class is there for others to build on: it is abstract, and some do."""
    return inspect.isabstract(cls) and bool(cls.__subclasses__())


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
    return meant(error)
