"""A loaded tree: what its file says, and its nodes as they are ticked, shown and recorded."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import Problem, UserError, nearest, relative
from humanoid_bt.core.sources import Sources
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.draft import Draft
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
        perception: the percept sources it is made for, if it says so.
        parameters: every parameter's value.
        source: the file's text.
        nodes: every node, parents before children, in the file's order.
        keys: the keys of its blackboard, those of its sub-trees left aside.
        header: the file's keys but for the root, as plain YAML.
        complete: whether its nodes can run: not those of a sub-tree whose parameters have no values.
        files: the tree file and those of its sub-trees.
        workspace: where its skills and sub-trees are from.
        warnings: what its checks found that does not keep it from running.
        draft: its root as its file describes it, from which nodes can be made anew; None if made in Python.
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
    workspace: Workspace | None = None
    warnings: tuple[Problem, ...] = ()
    draft: Draft | None = field(default=None, repr=False, compare=False)
    perception: Sources | None = None

    def __repr__(self) -> str:
        of = f", {', '.join(f'{name} = {value}' for name, value in self.parameters.items())}" if self.parameters else ""
        return f"<Tree {self.name!r}: {len(self.nodes)} nodes, {relative(self.path)}{of}>"

    def node(self, path: str) -> Node:
        """Return a node.

        Args:
            path: its path, or the end of it where no other node's ends so: "reach", "act on target/approach".

        Raises:
            UserError: there is none, or more than one.
        """
        if not isinstance(path, str):
            hint = "its path, or the end of it, as text"
            raise UserError(f"a node is named by its path, not by {path!r}", hint=hint, code="wrong-type")
        found = [node for node in self.nodes if node.path == path or node.path.endswith(f"/{path}")]
        exact = [node for node in found if node.path == path]
        if len(found) == 1 or exact:
            return (exact or found)[0]
        if found:
            message = f"{len(found)} nodes of the tree {self.name!r} have paths that end with {path!r}"
            raise UserError(message, hint=f"valid: {', '.join(node.path for node in found)}", code="unknown-node")
        names = [node.path.rsplit("/", 1)[-1] for node in self.nodes]
        message, hint = f"the tree {self.name!r} has no node {path!r}", nearest(path.rsplit("/", 1)[-1], names)
        raise UserError(message, hint=hint, code="unknown-node")

    @property
    def percepts(self) -> set[str]:
        """The percepts that its nodes ask for, by name."""
        asked = (node.type.percepts(node.values) for node in self.nodes)
        return {percept for names in asked for percepts in names.values() for percept in percepts}

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
