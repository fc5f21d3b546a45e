"""A node of a loaded tree, as it is ticked, shown, recorded and written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.errors import Place
from humanoid_bt.decision.result import ResultValue, results_of
from humanoid_bt.tree.node_type import Kind, NodeType


@dataclass(frozen=True, repr=False)
class Node:
    """One node of a tree.

    Attributes:
        path: names from the tree's down to this node's, joined by "/"; unique, equal siblings get ``#2``, ``#3``.
        name: as the file calls it, or its type's name.
        type: its type, with the declared parameters.
        values: the parameters that the file gives, converted.
        written: those of them that are written in another unit than the SI's, as they are written ("60 deg").
        references: parameter -> the name that the file gives for it as ``$name``.
        unresolved: its name, and parameters, that hold a ``$name`` in another way, as they are written.
        arguments: of a sub-tree: the nodes it is given, as plain YAML, or the nodes themselves if made in Python.
        place: where it is written.
        behaviour: the py_trees node.
        parent: index of its parent in the tree's nodes, -1 for the root.
        branch: the key of its parent that it stands under ("on_stale", "cases left"), "" for a plain child.
    """

    path: str
    name: str
    type: NodeType
    values: Mapping[str, Any]
    place: Place
    behaviour: Behaviour
    parent: int
    branch: str = ""
    references: Mapping[str, str] = field(default_factory=dict)
    arguments: Mapping[str, Any] = field(default_factory=dict)
    written: Mapping[str, Any] = field(default_factory=dict)
    unresolved: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"<Node {self.path!r}: {self.type_name}, {self.status.name}>"

    @property
    def type_name(self) -> str:
        """Its type as written in trees."""
        return self.type.type_name

    @property
    def status(self) -> Status:
        """Its status after the last tick; INVALID before the first, or when it was halted."""
        return self.behaviour.status

    @property
    def feedback(self) -> str:
        """What it said last."""
        return str(self.behaviour.feedback_message)

    @property
    def results(self) -> Mapping[str, ResultValue]:
        """What it has reported since it started, by name; only skills report something."""
        return results_of(self.behaviour)

    @property
    def kind(self) -> Kind:
        """Whether it is a composite, a decorator, a condition, an action or a skill."""
        return self.type.kind
