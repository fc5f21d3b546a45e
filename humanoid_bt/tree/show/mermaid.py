"""Trees as Mermaid flowcharts, which Markdown pages show as pictures."""

from __future__ import annotations

import re
from collections.abc import Mapping

from py_trees.common import Status

from humanoid_bt.core.texts import one_line
from humanoid_bt.tree.show.looks import LOOKS, MARKS, NEUTRAL, STATUS_COLORS, Color, hexadecimal, look_of, tint
from humanoid_bt.tree.show.outline import Outline, OutlineNode, outline_of
from humanoid_bt.tree.tree import Tree

_SHAPES = {
    "box": ("[", "]"),
    "round": ("(", ")"),
    "cut": ("{{", "}}"),
    "pill": ("([", "])"),
    "double": ("[[", "]]"),
}
_PLAIN = re.compile(r"[^\w ,.:/()+=~°·→▶✓✗○-]")  # what Mermaid, its Markdown or HTML might read as more than text
_PAIRED, _APART = "\\$", "#8203;"  # even as codes, a backslash before n and two dollars mean something


def mermaid_tree(
    tree: Tree | Outline,
    statuses: Mapping[str, Status] | None = None,
    feedback: Mapping[str, str] | None = None,
) -> str:
    """Return a tree as a Mermaid flowchart.

    Args:
        tree: the tree, or what is drawn of it.
        statuses: node path to status; colours and marks the nodes if given.
        feedback: node path to what the node says; shown in it.
    """
    outline = outline_of(tree)
    lines = ["flowchart TD"]
    used: dict[str, Color] = {}
    for index, node in enumerate(outline.nodes):
        status = None if statuses is None else statuses.get(node.path, Status.INVALID)
        style, color = _style(node, status)
        used[style] = color
        left, right = _SHAPES[look_of(node.kind).shape]
        text = _label(node, status, (feedback or {}).get(node.path, ""))
        lines.append(f'  n{index}{left}"{text}"{right}:::{style}')
    for index, node in enumerate(outline.nodes):
        if node.parent >= 0:
            arrow = f'-. "{_escaped(node.branch)}" .->' if node.branch else "-->"
            lines.append(f"  n{node.parent} {arrow} n{index}")
    for style, color in used.items():
        lines.append(f"  classDef {style} fill:{hexadecimal(tint(color))},stroke:{hexadecimal(color)},color:#1f2328")
    return "\n".join(lines) + "\n"


def _style(node: OutlineNode, status: Status | None) -> tuple[str, Color]:
    if status is not None:
        return status.name.lower(), STATUS_COLORS[status.name].light
    return (node.kind, LOOKS[node.kind].color) if node.kind in LOOKS else ("other", NEUTRAL.color)


def _label(node: OutlineNode, status: Status | None, feedback: str) -> str:
    mark = "" if status is None else f"{MARKS[status]} "
    rows = [f"{mark}<b>{_escaped(node.name)}</b>"]
    rows += [_escaped(text) for text in (node.type_label, *node.parameters) if text]
    if feedback:
        rows.append(f"<i>{_escaped(one_line(feedback))}</i>")
    return "<br/>".join(rows)


def _escaped(text: str) -> str:
    """Return a text whose signs are written as Mermaid's codes: ``#35;`` for ``#``."""
    return _PLAIN.sub(lambda found: f"#{ord(found[0])};{_APART if found[0] in _PAIRED else ''}", text)
