"""Showing trees as text and as Graphviz graphs."""

from __future__ import annotations

import json
import textwrap
from collections.abc import Mapping
from typing import Any

from py_trees.common import Status

from humanoid_bt.blackboard import Key
from humanoid_bt.tree.tree import Node, Tree

MARKS = {Status.SUCCESS: "✓", Status.FAILURE: "✗", Status.RUNNING: "▶", Status.INVALID: "○"}
"""How a status is shown."""

_GLUE = "\N{NO-BREAK SPACE}"
_SHAPES = {
    "composite": "box",
    "subtree": "folder",
    "decorator": "ellipse",
    "condition": "diamond",
    "action": "component",
    "skill": "component",
}


def parameter_text(node: Node) -> str:
    """Return the parameters of a node that differ from their defaults: ``percept: target, max_age: 0.5 s``."""
    shown = []
    for name, value in node.values.items():
        spec = node.type.params[name]
        if spec.required or value != spec.default:
            unit = f" {spec.unit}" if spec.unit and value is not None else ""
            reads = isinstance(value, Key) and name in node.references
            shown.append(f"{name}: ${node.references[name]}" if reads else f"{name}: {_value_text(value)}{unit}")
    return ", ".join(shown)


def unicode_tree(tree: Tree, statuses: Mapping[str, Status] | None = None, width: int = 80) -> str:
    """Return a tree drawn with lines.

    Args:
        tree: the tree.
        statuses: node path to status; shown as a mark before each name if given.
        width: columns to fit into as well as its depth allows.
    """
    children: dict[int, list[int]] = {}
    for index, node in enumerate(tree.nodes):
        children.setdefault(node.parent, []).append(index)
    title = f"{tree.name}: {tree.description}" if tree.description else tree.name
    lines = textwrap.wrap(title, width)

    def draw(index: int, before: str, last: bool) -> None:
        node = tree.nodes[index]
        mark = f"{MARKS[statuses.get(node.path, Status.INVALID)]} " if statuses is not None else ""
        label = f"{node.branch}: {node.name}" if node.branch else node.name
        if node.name != node.type_name:
            label += f" ({node.type_name})"
        below = before + ("   " if last else "│  ")
        head = f"{before}{'└─ ' if last else '├─ '}{mark}"
        inner = children.get(index, [])
        hanging = below + ("│    " if inner else "     ")
        text = f"{label}  {parameters}" if (parameters := parameter_text(node)) else label
        lines.extend(_wrapped(text, head, hanging, width))
        for child in inner:
            draw(child, below, child == inner[-1])

    draw(0, "", True)
    return "\n".join(lines)


def dot_tree(tree: Tree) -> str:
    """Return a tree as a Graphviz graph."""
    lines = [
        f"digraph {_quoted(tree.name)} {{",
        "  ordering=out;",
        '  node [fontname="Helvetica", fontsize=10];',
        '  edge [fontname="Helvetica", fontsize=9];',
    ]
    for index, node in enumerate(tree.nodes):
        parts = [node.name, f"({node.type_name})" if node.name != node.type_name else "", parameter_text(node)]
        label = _quoted("\n".join(part for part in parts if part))
        lines.append(f"  n{index} [label={label}, shape={_SHAPES[node.kind]}, tooltip={_quoted(node.path)}];")
    for index, node in enumerate(tree.nodes):
        if node.parent >= 0:
            label = f" [label={_quoted(node.branch)}, style=dashed]" if node.branch else ""
            lines.append(f"  n{node.parent} -> n{index}{label};")
    return "\n".join([*lines, "}"]) + "\n"


def _wrapped(text: str, first: str, others: str, width: int) -> list[str]:
    """Break a line between parameters where it is too long for the width."""
    label, gap, parameters = text.partition("  ")
    glued = [piece.replace(" ", _GLUE) for piece in (label, *parameters.split(", "))]
    lines = textwrap.wrap(
        glued[0] + gap + ", ".join(glued[1:]),
        width,
        initial_indent=first,
        subsequent_indent=others,
        break_long_words=False,
        break_on_hyphens=False,
    )
    return [line.replace(_GLUE, " ") for line in lines]


def _value_text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _quoted(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
