"""From the files of interfaces to sources in C, C++ and Python, with the generators of ROS 2."""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import Place, UserError, relative
from humanoid_bt.gateway.interfaces.package import Package

TYPE_SUPPORTS = ("rosidl_typesupport_fastrtps_c", "rosidl_typesupport_introspection_c")
"""What a middleware can ask for."""

_GENERATORS = {
    "rosidl_generator_c": "GenerateC",
    "rosidl_typesupport_c": "GenerateCTypesupport",
    "rosidl_typesupport_fastrtps_c": "GenerateFastRTPSCTypesupport",
    "rosidl_typesupport_introspection_c": "GenerateIntrospectionCTypesupport",
    "rosidl_generator_py": "GeneratePython",
}
_INCLUDE = re.compile(r'#include "(.+)/(.+)/(.+)\.idl"')
_LINE = re.compile(r"^Error processing '(.*)' of '", re.MULTILINE)


@dataclass(frozen=True)
class Sources:
    """The sources of a package.

    Attributes:
        folder: a folder for each generator, and in it one with the package's name.
        interfaces: folder of ``msg/Point.idl`` and ``msg/Point.json``, of which other packages' sources are made.
    """

    folder: Path
    interfaces: Path


def generate(package: Package, prefixes: Sequence[Path], folder: Path) -> Sources:
    """Write the sources of a package.

    Args:
        package: it.
        prefixes: where other packages are installed, the first that has one counts.
        folder: for what is written.

    Raises:
        UserError: a file of the package is wrong, or a type it names is not there.
    """
    interfaces = folder / "share" / package.name
    others = _others(package, prefixes)
    os.environ["AMENT_PREFIX_PATH"] = sys.prefix  # where the generators look for their templates
    for file in package.files:
        _translate(package, file, interfaces / file.parent)
        _check_types(package, file, interfaces, others)
    found = [f"{interfaces}:{file.with_suffix('.idl')}" for file in package.files]
    shares = [str(share) for share in others.values()]
    with _quiet() as said:
        hashes = _extension("rosidl_generator_type_description", "HashTypeDescription")
        described = hashes.generate_type_hashes(package.name, found, shares, interfaces)
        for module, name in _GENERATORS.items():
            more = {"type_description_files": described} if module == "rosidl_generator_c" else {}
            generator = _extension(module, name, _options(module))
            generator.generate(package.name, found, shares, folder / module / package.name, **more)
    if keyword := re.search(r"Member name '(\w+)' .* '(\w+)' is a reserved keyword", said.getvalue()):
        message = f"the field {keyword[1]!r} of {keyword[2]!r} is a keyword of Python"
        raise UserError(message, Place(relative(package.folder)), "another name")
    (folder / "rosidl_generator_py" / package.name / "__init__.py").touch()
    return Sources(folder, interfaces)


def _options(module: str) -> Mapping[str, Any]:
    if module == "rosidl_typesupport_c":
        return {"typesupport_implementations": list(TYPE_SUPPORTS)}
    if module == "rosidl_generator_py":
        return {"typesupport_implementations": ["rosidl_typesupport_c", *TYPE_SUPPORTS]}
    return {}


def _extension(module: str, name: str, options: Mapping[str, Any] | None = None) -> Any:
    return getattr(importlib.import_module(f"{module}.cli"), name)(module, **(options or {}))


@contextlib.contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """Keep what the generators print."""
    said = io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(said):
        yield said


def _translate(package: Package, file: Path, to: Path) -> None:
    """Write a file in the common language of definitions, IDL."""
    kind = file.suffix[1:]
    convert = getattr(importlib.import_module(f"rosidl_adapter.{kind}"), f"convert_{kind}_to_idl")
    to.mkdir(parents=True, exist_ok=True)
    with _quiet() as said:
        try:
            convert(package.folder, package.name, file, to)
        except Exception as error:  # of any class, by the mistake
            wrong = _LINE.search(said.getvalue())
            line = _number_of(wrong[1] if wrong else str(error), package.folder / file)
            place = Place(relative(package.folder / file), line, 1 if line else 0)
            what = f"this is no field: {error}" if type(error).__name__ == "InvalidFieldDefinition" else str(error)
            raise UserError(what, place, f"as TYPE NAME, of {_KINDS[kind]}") from None


_KINDS = {
    "msg": "a message",
    "srv": "a service: request and response, with a line --- between them",
    "action": "an action: goal, result and feedback, with lines --- between them",
}


def _number_of(text: str, file: Path) -> int:
    lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
    return next((number for number, line in enumerate(lines, 1) if text in line), 0)


def _check_types(package: Package, file: Path, interfaces: Path, others: Mapping[str, Path]) -> None:
    """Refuse a file that names a type which nobody has defined."""
    own = {other.with_suffix("") for other in package.files}
    for name, kind, type_ in _INCLUDE.findall((interfaces / file.with_suffix(".idl")).read_text(encoding="utf-8")):
        place = Place(relative(package.folder / file))
        if name == package.name:
            if Path(kind, type_) not in own:
                raise UserError(f"the package has no {kind} {type_!r}", place, f"a file {kind}/{type_}.{kind}")
        elif name not in others:
            wheel = name.replace("_", "-")
            hint = f"pip install ros-kilted-{wheel}, or name its folder before this one"
            raise UserError(f"the package {name!r}, of {name}/{type_}, is not installed", place, hint, "no-file")
        elif not (others[name] / kind / f"{type_}.idl").is_file():
            raise UserError(f"the package {name!r} has no {kind} {type_!r}", place, code="unknown-key")


def _others(package: Package, prefixes: Sequence[Path]) -> dict[str, Path]:
    """Return the folders of the interfaces of all other packages by their names."""
    found: dict[str, Path] = {}
    for prefix in prefixes:
        for file in prefix.glob("share/*/*/*.idl"):
            found.setdefault(file.parents[1].name, file.parents[1])
    found.pop(package.name, None)
    return found
