"""Loading tree files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from humanoid_bt import document
from humanoid_bt.document import Item
from humanoid_bt.errors import Problem, UserError, relative
from humanoid_bt.params import param, params_of, read_values
from humanoid_bt.tree.build import build
from humanoid_bt.tree.check import check_safety
from humanoid_bt.tree.parameters import Parameters
from humanoid_bt.tree.read import Draft, Reader, check_name
from humanoid_bt.tree.registry import Registry
from humanoid_bt.tree.tree import Node, Tree
from humanoid_bt.workspace import Workspace


@dataclass(frozen=True)
class Header:
    """The keys of a tree file besides ``parameters`` and ``root``."""

    format: Literal[1] = param(doc="Version of this file's form: 1.")
    name: str = param("", doc="The tree's name; the file's if not given.")
    description: str = param("", doc="One line for people.")
    robot: str | None = param(None, doc="The robot it is made for.")
    scene: str | None = param(None, doc="The scene it is made for.")


PARTS = {"parameters": "The tree's parameters: name to default.", "root": "The root node."}
"""The keys of a tree file besides its header."""


def load_tree(path: Path, workspace: Workspace, overrides: Mapping[str, str] | None = None) -> Tree:
    """Read, check and build a tree.

    Args:
        path: the tree file.
        workspace: where its skills are found.
        overrides: parameter values as text, from ``--set name=value``.

    Raises:
        UserError: with every mistake found, each with its place.
    """
    source = document.read_text(path)
    problems: list[Problem] = []
    item = document.parse(source, relative(path), problems)
    if not isinstance(item.value, dict):
        problems.append(
            Problem(f"a tree file must be a mapping, not {item.kind}", item.place, "format: 1 ... root: ...")
        )
        raise UserError(problems)
    header = _header(item, problems)
    parameters = Parameters(item.value.get("parameters"), overrides or {}, problems)
    name = header.get("name") or path.stem
    registry = _registry(workspace, problems)
    root = _root(item, Reader(registry, parameters, problems), problems) if registry else None
    nodes: tuple[Node, ...] = ()
    if root is not None:
        parameters.report_unused()
        problems += check_safety(root)
        nodes = build(root, name, problems)
    if problems:
        raise UserError(_in_file_order(problems, item))
    return Tree(
        name=name,
        description=header.get("description", ""),
        path=path,
        robot=header.get("robot"),
        scene=header.get("scene"),
        parameters=parameters.values,
        source=source,
        nodes=nodes,
        files=(path,),
    )


def _header(item: Item, problems: list[Problem]) -> dict[str, Any]:
    values, found = read_values(params_of(Header), item, "a tree", frozenset(PARTS), noun="key")
    problems += found
    if values.get("name"):
        try:
            check_name(item.value["name"])
        except UserError as error:
            problems += error.problems
    return values


def _registry(workspace: Workspace, problems: list[Problem]) -> Registry | None:
    try:
        return Registry.of(workspace)
    except UserError as error:
        problems += error.problems
        return None


def _root(item: Item, reader: Reader, problems: list[Problem]) -> Draft | None:
    if "root" not in item.value:
        problems.append(Problem("the key 'root' of a tree is missing", item.place, "root: the root node"))
        return None
    return reader.node(item.value["root"], "the root")


def _in_file_order(problems: list[Problem], item: Item) -> list[Problem]:
    """Return the problems as a reader meets them: those of the tree file by line, then the others."""

    def order(problem: Problem) -> tuple[bool, int, int]:
        place = problem.place
        if place is None or place.file != item.place.file:
            return (True, 0, 0)
        return (False, place.line, place.column)

    return sorted(dict.fromkeys(problems), key=order)
