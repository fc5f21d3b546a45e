"""A loaded tree: what its file says, and its nodes as they are ticked, shown and recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.write import tree_text


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
        keys: the keys of its blackboard, those of its sub-trees left aside.
        header: the file's keys but for the root, as plain YAML.
        complete: whether its nodes can run: not those of a sub-tree whose parameters have no values.
        files: the tree file and those of its sub-trees.
        warnings: what its checks found that does not keep it from running.
    """

    name: str
    description: str
    path: Path
    robot: str | None
    scene: str | None
    parameters: Mapping[str, Any]
    source: str
    nodes: tuple[Node, ...]
    keys: tuple[Key, ...] = ()
    header: Mapping[str, Any] = field(default_factory=dict)
    complete: bool = True
    files: tuple[Path, ...] = ()
    warnings: tuple[Problem, ...] = ()

    def to_yaml(self) -> str:
        """Return the text of a file that loads to the same tree; sub-trees stay in their own files.

        Raises:
            UserError: a parameter has a value that no file can hold, or the tree could not be made.
        """
        if not self.complete:
            message = f"the sub-tree {self.name!r} is incomplete without its parameters"
            raise UserError(message, code="missing-parameter")
        return tree_text(self.name, self.header, self.nodes)

    @property
    def is_subtree(self) -> bool:
        """Whether it is made for use in other trees."""
        return bool(self.header.get("subtree"))

    @property
    def root(self) -> Behaviour:
        """The root's behaviour."""
        return self.nodes[0].behaviour
