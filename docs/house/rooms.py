"""The rooms of the package: which there are and who may import whom, what each says it is, what it does import.

The order is that of the layers in ``pyproject.toml``, the sentences are those of the docstrings, the imports are those
that the code has.
"""

from __future__ import annotations

import ast
import re
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import blocks
import grimp

PACKAGE = "humanoid_bt"
_APART, _TOGETHER = "|", ":"  # how layers separate those that may not, and those that may import each other
_Layer = tuple[list[str], bool]  # names of modules, and whether they may import each other


@dataclass(frozen=True)
class Room:
    """A part of the package: a folder, or a file that is a layer of its own inside of one.

    Attributes:
        path: of the folder or file.
        says: the first sentence of its docstring, "" if it has none.
        floors: what is inside of it, the highest layer first.
        imports: names of the rooms beside and below that it imports, the highest first.
        sober: whether a contract forbids it to know trees and viewers.
    """

    path: Path
    says: str
    floors: tuple[Floor, ...] = ()
    imports: tuple[str, ...] = ()
    sober: bool = False

    @property
    def name(self) -> str:
        """Its name in a picture: that of a folder, or of a file with its ending."""
        return self.path.name

    @property
    def is_folder(self) -> bool:
        """Whether it is a folder."""
        return not self.path.suffix


@dataclass(frozen=True)
class Floor:
    """Rooms in one layer.

    Attributes:
        rooms: the rooms, in the order of the contract.
        open: whether they may import each other.
    """

    rooms: tuple[Room, ...]
    open: bool = False

    def __iter__(self) -> Iterator[Room]:
        return iter(self.rooms)


def house() -> tuple[Floor, ...]:
    """Return the floors of the house, the highest first."""
    contracts = _contracts()
    layers = _layers(contracts)
    imports = _imports()
    forbidden = [contract for contract in contracts if "py_trees" in contract.get("forbidden_modules", ())]
    sober = {name for contract in forbidden for name in contract["source_modules"]}
    order = [name for names, _ in layers[PACKAGE] for name in names]
    floors = []
    for names, is_open in layers[PACKAGE]:
        rooms = []
        for name in names:
            below = tuple(other.rpartition(".")[2] for other in order if other in imports[name])
            rooms.append(Room(_path(name), says(name), _inside(name, layers), below, name in sober))
        floors.append(Floor(tuple(rooms), is_open))
    return tuple(floors)


def says(module: str) -> str:
    """Return the first sentence of a module's docstring, "" if it has none."""
    path = _path(module)
    source = (path / "__init__.py" if path.is_dir() else path).read_text(encoding="utf-8")
    paragraph = (ast.get_docstring(ast.parse(source)) or "").partition("\n\n")[0].replace("\n", " ")
    return re.split(r"(?<=\.)\s", paragraph)[0].replace("``", "")


def _inside(name: str, layers: Mapping[str, Sequence[_Layer]]) -> tuple[Floor, ...]:
    """Return what is in a room: its layers if there is a contract on them, else its folders."""
    folders = [f"{name}.{file.parent.name}" for file in sorted(_path(name).glob("*/__init__.py"))]
    inner = layers.get(name) or ([(folders, True)] if folders else [])
    return tuple(Floor(tuple(Room(_path(part), says(part)) for part in names), is_open) for names, is_open in inner)


def _path(module: str) -> Path:
    path = blocks.ROOT.joinpath(*module.split("."))
    return path if path.is_dir() else path.with_suffix(".py")


def _contracts() -> list[dict[str, Any]]:
    project = tomllib.loads((blocks.ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts: list[dict[str, Any]] = project["tool"]["importlinter"]["contracts"]
    return contracts


def _layers(contracts: Sequence[dict[str, Any]]) -> dict[str, list[_Layer]]:
    """Return module -> the layers inside of it, the highest first."""
    found: dict[str, list[_Layer]] = {}
    for contract in contracts:
        if contract["type"] != "layers":
            continue
        prefix = f"{contract['containers'][0]}." if "containers" in contract else ""
        layers = [
            ([prefix + name.strip() for name in re.split(rf"[{_APART}{_TOGETHER}]", layer)], _TOGETHER in layer)
            for layer in contract["layers"]
        ]
        found[layers[0][0][0].rpartition(".")[0]] = layers
    return found


@cache
def _imports() -> dict[str, set[str]]:
    """Return room -> the rooms that any of its files imports."""
    graph = grimp.build_graph(PACKAGE, cache_dir=None)
    found: dict[str, set[str]] = {_room(module): set() for module in graph.modules}
    for module in graph.modules:
        found[_room(module)] |= {_room(other) for other in graph.find_modules_directly_imported_by(module)}
    return {room: others - {room} for room, others in found.items()}


def _room(module: str) -> str:
    return ".".join(module.split(".")[:2])
