"""Tree files: what is in them besides their nodes."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

from humanoid_bt.core.errors import Problem, UserError, relative
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import param, params_of
from humanoid_bt.core.reading import read_values
from humanoid_bt.core.sources import Sources
from humanoid_bt.files import document
from humanoid_bt.files.reading import read_text
from humanoid_bt.tree.node_type import NODE_KEYS
from humanoid_bt.tree.source.parameters import Argument, Declaration, LongForm, declarations, inferred
from humanoid_bt.tree.write import written


@dataclass(frozen=True)
class Header:
    """The keys of a tree file that say what it is."""

    format: Literal[1] = param(doc="Version of this file's form: 1.")
    name: str = param("", doc="The tree's name; the file's if not given.")
    description: str = param("", doc="One line for people.")
    robot: str | None = param(None, doc="The robot it is made for.")
    scene: str | None = param(None, doc="The scene it is made for.")
    perception: Sources | None = param(None, doc="The percept sources it is made for; default: what the scene says.")
    subtree: bool = param(
        False,
        doc="It is made for use in other trees, which give what it needs: an emergency_stop and watchdogs around it, "
        "and the parameters without a default.",
    )


PARTS = {
    "parameters": "The tree's parameters: name to default, or to a declaration in full.",
    "blackboard": "Keys with an initial value or a type: name to value, or to a declaration in full.",
    "outputs": "Keys that a tree which uses this one can bind to its own: name to a declaration, without a default.",
    "root": "The root node.",
}
"""The keys of a tree file besides its header."""


@dataclass(frozen=True, eq=False)
class TreeFile:
    """One tree file, read but for its nodes.

    Attributes:
        path: where it is.
        source: its text.
        item: what is in it.
        header: the values of :class:`Header`.
        parameters, blackboard, outputs: what it declares.
    """

    path: Path
    source: str
    item: Item
    header: dict[str, Any]
    parameters: dict[str, Declaration]
    blackboard: dict[str, Declaration]
    outputs: dict[str, Declaration]

    @property
    def root(self) -> Item | None:
        """The root node, None if the file has none."""
        root: Item | None = self.item.value.get("root")
        return root

    @property
    def name(self) -> str:
        """The tree's name."""
        return self.header.get("name") or self.path.stem

    def plain_header(self, given: Mapping[str, Argument]) -> dict[str, Any]:
        """Return the file's keys but for the root as plain YAML, with parameters as they were given."""
        header = {key: item.plain() for key, item in self.item.value.items() if key != "root"}
        header["name"] = self.name
        for name, argument in given.items():
            declared, spec = header["parameters"][name], self.parameters[name].spec
            value = written(argument.value if argument.written is None else argument.written, spec.unit)
            if isinstance(declared, dict):
                unit = {"unit": argument.unit} if argument.unit else {}
                value = {**declared, **unit, "default": value}
            elif spec.type is str and inferred(name, Item(value, argument.place)).type is not str:
                value = {"type": "text", "default": value}
            header["parameters"][name] = value
        return header


def read_file(path: Path, problems: list[Problem]) -> TreeFile:
    """Return a tree file, read but for its nodes.

    Args:
        path: where it is.
        problems: takes every mistake after which reading can go on.

    Raises:
        UserError: it cannot be read as a mapping.
    """
    found: list[Problem] = []
    source = read_text(path)
    try:
        item = document.parse(source, relative(path), found)
    except UserError as error:
        raise UserError([*found, *error.problems]) from error
    if not isinstance(item.value, dict):
        message = f"a tree file must be a mapping, not {item.kind}"
        found.append(Problem(message, item.place, "format: 1 ... root: ...", "wrong-type"))
        raise UserError(found)
    item = _mended(item, found)
    if "root" not in item.value:
        message = "the key 'root' of a tree is missing"
        found.append(Problem(message, item.place, "root: the root node", "missing-key"))
    file = TreeFile(
        path,
        source,
        item,
        _header(item, found),
        declarations(item.value.get("parameters"), "parameter", found),
        declarations(item.value.get("blackboard"), "key", found),
        declarations(item.value.get("outputs"), "output", found),
    )
    _check_names(file, found)
    _check_outputs(file, found)
    problems += found
    return file


def _mended(item: Item, problems: list[Problem]) -> Item:
    """Return what a file most likely means where its own keys are misspelt or its root is not below ``root``."""
    known = [*params_of(Header), *PARTS]
    values, places = dict(item.value), dict(item.key_places)
    for key in [key for key in values if key not in known]:
        meant = difflib.get_close_matches(key.lower(), [part for part in PARTS if part not in values], n=1, cutoff=0.75)
        for part in meant:
            message, hint = f"unknown key {key!r} of a tree", f"did you mean {part!r}?"
            problems.append(Problem(message, places[key], hint, "unknown-key"))
            values[part], places[part] = values.pop(key), places.pop(key)
    unknown = [key for key in values if key not in known]
    if "root" in values and values["root"].value is None and len(unknown) == 1:
        key = unknown[0]
        message, hint = f"{key!r} is not indented below 'root'", "indent it, and all that belongs to it"
        problems.append(Problem(message, places[key], hint, "not-a-node"))
        values["root"] = Item({key: values.pop(key)}, places[key], {key: places[key]})
    declared = values.get("parameters")
    if "root" not in values and declared is not None and isinstance(declared.value, dict):
        for key, value in declared.value.items():
            if isinstance(value.value, dict) and not value.value.keys() & params_of(LongForm).keys():
                place = declared.key_places[key]
                problems.append(Problem(f"the key 'root' above {key!r} is missing", place, "root:", "missing-key"))
                values["root"] = Item({key: value}, place, {key: place})
                others = {name: other for name, other in declared.value.items() if name != key}
                values["parameters"] = Item(others, declared.place, declared.key_places)
                break
    return Item(values, item.place, places)


def check_name(item: Item) -> None:
    """Check what a node or tree is called.

    Raises:
        UserError: it cannot be a part of a path.
    """
    name = item.value
    if not isinstance(name, str):
        raise UserError(f"a name must be text, not {item.kind}", item.place, code="wrong-type")
    if not name.strip() or "/" in name or not name.isprintable():
        raise UserError(f"{name!r} cannot be a name", item.place, "one line of text without /", "bad-name")


def _header(item: Item, problems: list[Problem]) -> dict[str, Any]:
    values, found = read_values(params_of(Header), item, "a tree", frozenset(PARTS), noun="key")
    form = item.value["format"].place if "format" in item.value else None
    problems += [replace(problem, code="format") if problem.place == form else problem for problem in found]
    if values.get("name"):
        try:
            check_name(item.value["name"])
        except UserError as error:
            problems += error.problems
    return values


def _check_names(file: TreeFile, problems: list[Problem]) -> None:
    """Note parameters and outputs whose names a node has already."""
    taken = {"tree", *NODE_KEYS}
    for name, declared in [*file.parameters.items(), *file.outputs.items()]:
        if name in taken:
            message = f"{name!r} cannot be called so: every sub-tree node has a key of this name"
            problems.append(Problem(message, declared.place, "rename it", "taken-name"))
    for name in file.outputs.keys() & file.parameters.keys():
        message = f"the name {name!r} is declared twice in one tree"
        problems.append(Problem(message, file.outputs[name].place, "rename one of them", "taken-name"))


def _check_outputs(file: TreeFile, problems: list[Problem]) -> None:
    """Note outputs with a default: they get what the tree writes, and have no value before."""
    for name, declared in file.outputs.items():
        if declared.default is not None:
            message = f"the output {name!r} cannot have a default: it has no value until a node writes it"
            hint = f"{name}: {{type: ...}}, and a set_blackboard where the tree begins"
            problems.append(Problem(message, declared.default.place, hint, "misplaced-key"))
