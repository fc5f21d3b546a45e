"""A loaded tree: what its file says, and its nodes as they are ticked, shown and recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from humanoid_bt.errors import Place, Problem
from humanoid_bt.tree.registry import Kind, NodeType


@dataclass(frozen=True)
class Node:
    """One node of a tree.

    Attributes:
        path: names from the tree's down to this node's, joined by "/"; unique, equal siblings get ``#2``, ``#3``.
        name: as the file calls it, or its type's name.
        type: its type, with the declared parameters.
        values: the parameters that the file gives, converted.
        place: where it is written.
        behaviour: the py_trees node.
        parent: index of its parent in the tree's nodes, -1 for the root.
        branch: the key of its parent that it stands under ("on_stale"), "" for a plain child.
    """

    path: str
    name: str
    type: NodeType
    values: Mapping[str, Any]
    place: Place
    behaviour: Behaviour
    parent: int
    branch: str = ""

    @property
    def type_name(self) -> str:
        """Its type as written in trees."""
        return self.type.type_name

    @property
    def kind(self) -> Kind:
        """Whether it is a composite, a decorator, a condition, an action or a skill."""
        return self.type.kind


@dataclass(frozen=True)
class Tree:
    """A loaded tree.

    Attributes:
        name: from the file, or the file's own.
        description: one line for people.
        path: the file.
        robot: name of the robot it is made for, if it says so.
        scene: name of the scene it is made for, if it says so.
        parameters: every parameter's value.
        source: the file's text.
        nodes: every node, parents before children, in the file's order.
        warnings: what its checks found that does not keep it from running.
        files: every tree file it was read from.
    """

    name: str
    description: str
    path: Path
    robot: str | None
    scene: str | None
    parameters: Mapping[str, Any]
    source: str
    nodes: tuple[Node, ...]
    warnings: tuple[Problem, ...] = ()
    files: tuple[Path, ...] = ()

    @property
    def root(self) -> Behaviour:
        """The root's behaviour."""
        return self.nodes[0].behaviour
