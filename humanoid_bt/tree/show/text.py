"""Trees as text, drawn with lines."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import NamedTuple

from py_trees.common import Status

from humanoid_bt.core.texts import one_line
from humanoid_bt.tree.show.looks import MARKS
from humanoid_bt.tree.show.outline import Outline, outline_of
from humanoid_bt.tree.tree import Tree

_FEEDBACK = "→ "
_NARROWEST = 16  # columns that a piece is not broken for


class Line(NamedTuple):
    """A line of a drawn tree.

    Attributes:
        node: index of the node it is about, -1 for the tree's title.
        guide: the lines that lead to the node.
        text: what it says.
    """

    node: int
    guide: str
    text: str


def unicode_tree(
    tree: Tree | Outline,
    statuses: Mapping[str, Status] | None = None,
    width: int = 80,
    feedback: Mapping[str, str] | None = None,
) -> str:
    """Return a tree drawn with lines.

    Args:
        tree: the tree, or what is drawn of it.
        statuses: node path to status; shown as a mark before each name if given.
        width: columns to fit into as well as its depth allows.
        feedback: node path to what the node says; shown below it.
    """
    return "\n".join(line.guide + line.text for line in lines_of(outline_of(tree), statuses, width, feedback))


def lines_of(
    outline: Outline,
    statuses: Mapping[str, Status] | None = None,
    width: int = 80,
    feedback: Mapping[str, str] | None = None,
) -> list[Line]:
    """Return the lines of :func:`unicode_tree`, each with what it is about."""
    title = f"{outline.name}: {outline.description}" if outline.description else outline.name
    lines = [Line(-1, "", text) for text in textwrap.wrap(title, width)]
    children = outline.children()
    guides = [""] * len(outline.nodes)  # what stands before each node's children
    for index in outline.in_order():
        node = outline.nodes[index]
        before = guides[node.parent] if node.parent >= 0 else ""
        last = node.parent < 0 or index == children[node.parent][-1]
        guides[index] = before + ("   " if last else "│  ")
        mark = f"{MARKS[statuses.get(node.path, Status.INVALID)]} " if statuses is not None else ""
        first = before + ("└─ " if last else "├─ ")
        further = guides[index] + ("│" if children[index] else " ")
        label = " ".join(filter(None, [node.title, node.type_label]))
        pieces = [f"{label} " if node.parameters else label, *(f"{text}," for text in node.parameters[:-1])]
        pieces += node.parameters[-1:]
        room = width - len(further)
        wrapped = _wrapped(pieces, width - len(first + mark), room - 4)
        lines.append(Line(index, first, mark + wrapped[0]))
        lines += [Line(index, further, "    " + text) for text in wrapped[1:]]
        if feedback and (said := one_line(feedback.get(node.path, ""))):
            indent = " " * (len(mark) + 2)
            head = f"{indent}{_FEEDBACK}"
            said_lines = textwrap.wrap(said, max(room, len(head) + 8), initial_indent=head, subsequent_indent=indent)
            lines += [Line(index, further, text) for text in said_lines]
    return lines


def _wrapped(pieces: list[str], first: int, others: int) -> list[str]:
    """Break a line between pieces, and long ones between words, into one line of a width and others of another."""
    lines = [""]
    fits = [[piece] if len(piece) <= max(others, _NARROWEST) else piece.split() for piece in pieces]
    for piece in (part for parts in fits for part in parts):
        room = first if len(lines) == 1 else others
        joined = f"{lines[-1]} {piece}" if lines[-1] else piece
        if len(joined) <= room or not lines[-1]:
            lines[-1] = joined
        else:
            lines.append(piece)
    return [line.rstrip() for line in lines]
