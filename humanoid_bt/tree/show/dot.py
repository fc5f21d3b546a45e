"""Trees as Graphviz graphs."""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.common import Status

from humanoid_bt.core.texts import one_line
from humanoid_bt.tree.show.looks import MARKS, STATUS_COLORS, hexadecimal, look_of, tint
from humanoid_bt.tree.show.outline import Outline, OutlineNode, outline_of
from humanoid_bt.tree.tree import Tree

_SHAPES = {
    "box": "shape=box, style=filled",
    "round": 'shape=box, style="filled,rounded"',
    "cut": "shape=octagon, style=filled",
    "pill": "shape=ellipse, style=filled",
    "double": "shape=box, peripheries=2, style=filled",
}


def dot_tree(
    tree: Tree | Outline,
    statuses: Mapping[str, Status] | None = None,
    feedback: Mapping[str, str] | None = None,
) -> str:
    """Return a tree as a Graphviz graph.

    Args:
        tree: the tree, or what is drawn of it.
        statuses: node path to status; colours and marks the nodes if given.
        feedback: node path to what the node says; shown in it.
    """
    outline = outline_of(tree)
    lines = [
        f"digraph {_quoted(outline.name)} {{",
        "  ordering=out;",
        '  node [fontname="Helvetica", fontsize=10];',
        '  edge [fontname="Helvetica", fontsize=9];',
    ]
    for index, node in enumerate(outline.nodes):
        status = None if statuses is None else statuses.get(node.path, Status.INVALID)
        lines.append(f"  n{index} [{_attributes(node, status, (feedback or {}).get(node.path, ''))}];")
    for index, node in enumerate(outline.nodes):
        if node.parent >= 0:
            label = f" [label={_quoted(node.branch)}, style=dashed]" if node.branch else ""
            lines.append(f"  n{node.parent} -> n{index}{label};")
    return "\n".join([*lines, "}"]) + "\n"


def _attributes(node: OutlineNode, status: Status | None, feedback: str) -> str:
    look = look_of(node.kind)
    color = look.color if status is None else STATUS_COLORS[status.name].light
    name = node.name if status is None else f"{MARKS[status]} {node.name}"
    text = "\n".join(filter(None, [name, node.type_label, ", ".join(node.parameters), one_line(feedback)]))
    colors = f'color="{hexadecimal(color)}", fillcolor="{hexadecimal(tint(color))}"'
    return f"label={_quoted(text)}, {_SHAPES[look.shape]}, {colors}, tooltip={_quoted(node.hint)}"


def _quoted(text: str) -> str:
    """Return a quoted string whose escapes and entities say what the text says."""
    for sign, instead in (("&", "&amp;"), ("\\", "\\\\"), ('"', '\\"'), ("\n", "\\n")):
        text = text.replace(sign, instead)
    return f'"{text}"'
