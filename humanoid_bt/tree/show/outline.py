"""What is drawn of a tree: plain text and numbers, without its nodes, so that other processes can draw it too."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, Self

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.texts import one_line
from humanoid_bt.core.units import spaced
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.tree import Tree


@dataclass(frozen=True)
class OutlineNode:
    """What is drawn of a node.

    Attributes:
        path, name, type_name, kind, parent, branch: as of :class:`~humanoid_bt.tree.tree.Node`.
        parameters: those that its file gives, each as ``name: value``.
        doc: one line about its type.
    """

    path: str
    name: str
    type_name: str
    kind: str
    parent: int
    branch: str = ""
    parameters: tuple[str, ...] = ()
    doc: str = ""

    @property
    def title(self) -> str:
        """Its name, behind what it is to its parent if that says it: ``on_stale: idle``."""
        return f"{self.branch}: {self.name}" if self.branch else self.name

    @property
    def type_label(self) -> str:
        """Its type in parentheses, "" if its name says it."""
        return f"({self.type_name})" if self.name != self.type_name else ""

    @property
    def hint(self) -> str:
        """Its path and what its type does, for tooltips."""
        return f"{self.path}\n{self.type_name}: {self.doc}" if self.doc else self.path


@dataclass(frozen=True)
class Outline:
    """What is drawn of a tree.

    Attributes:
        name, description: of the tree.
        nodes: parents before children, in the file's order.
    """

    name: str
    description: str
    nodes: tuple[OutlineNode, ...]

    @classmethod
    def of(cls, tree: Tree) -> Self:
        """Return the outline of a tree."""
        return cls(tree.name, one_line(tree.description), tuple(map(_outline_node, tree.nodes)))

    def to_json(self) -> str:
        """Return it as JSON."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Return what :meth:`to_json` wrote.

        Raises:
            ValueError: this is none of that.
        """
        try:
            data = json.loads(text)
            nodes = [OutlineNode(**{**node, "parameters": tuple(node["parameters"])}) for node in data["nodes"]]
            return cls(str(data["name"]), str(data["description"]), tuple(nodes))
        except (TypeError, KeyError) as error:
            raise ValueError(f"not an outline: {error!r}") from error

    def children(self) -> list[list[int]]:
        """Return the indices of each node's children."""
        found: list[list[int]] = [[] for _ in self.nodes]
        for index, node in enumerate(self.nodes):
            if node.parent >= 0:
                found[node.parent].append(index)
        return found

    def in_order(self) -> list[int]:
        """Return the nodes as a reader meets them: a node, then what is below it, then its next sibling."""
        children = self.children()
        order: list[int] = []
        stack = [0] if children else []
        while stack:
            order.append(stack.pop())
            stack += reversed(children[order[-1]])
        return order


def outline_of(tree: Tree | Outline) -> Outline:
    """Return what is drawn of a tree.

    Raises:
        UserError: it is none.
    """
    if isinstance(tree, Outline):
        return tree
    if not isinstance(tree, Tree):
        hint = "hbt.load(NAME) gives the tree of a file"
        raise UserError(f"only a tree can be drawn, not {tree!r}", hint=hint, code="wrong-type")
    return Outline.of(tree)


def _outline_node(node: Node) -> OutlineNode:
    return OutlineNode(
        path=node.path,
        name=node.name,
        type_name=node.type_name,
        kind=node.kind,
        parent=node.parent,
        branch=node.branch,
        parameters=tuple(_parameters(node)),
        doc=one_line(node.type.doc),
    )


def _parameters(node: Node) -> list[str]:
    shown = []
    for name, value in _values(node).items():
        if name in node.references and (isinstance(value, Key) or name not in node.values):
            shown.append(f"{name}: ${node.references[name]}")
        elif name in node.written:
            shown.append(f"{name}: {one_line(_value_text(spaced(node.written[name])))}")
        else:
            spec = node.type.params.get(name)
            unit = f" {spec.unit}" if spec is not None and spec.unit and _is_number(value) else ""
            shown.append(f"{name}: {one_line(_value_text(value))}{unit}")
    return shown


def _values(node: Node) -> dict[str, Any]:
    """Return the values that are given, None for a parameter of a sub-tree that has none, in the declared order."""
    given = dict.fromkeys(node.references) | dict(node.values)
    return {name: given[name] for name in (*node.type.params, *given) if name in given}


def _is_number(value: Any) -> bool:
    if isinstance(value, (list, tuple)):
        return bool(value) and all(map(_is_number, value))
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _value_text(value: Any) -> str:
    """Return a value as a tree file would say it; what is no plain data says itself what it is."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_value_text, value))}]"
    if isinstance(value, dict):
        return f"{{{', '.join(f'{key}: {_value_text(inner)}' for key, inner in value.items())}}}"
    return f"{value:g}" if isinstance(value, float) else str(value)
