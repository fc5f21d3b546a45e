"""Trees as SVG pictures, to be read: laid out here, without any other program."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple
from xml.sax.saxutils import escape

from py_trees.common import Status

from humanoid_bt.core.texts import one_line
from humanoid_bt.tree.show import shapes
from humanoid_bt.tree.show.layout import Box, tidy
from humanoid_bt.tree.show.looks import LOOKS, look_of
from humanoid_bt.tree.show.metrics import text_width, wrap
from humanoid_bt.tree.show.outline import Outline, OutlineNode, outline_of
from humanoid_bt.tree.show.style import STYLE
from humanoid_bt.tree.tree import Tree

_NAME, _SMALL, _TITLE = 13.0, 11.0, 16.0  # sizes of letters
_LINE = {_NAME: 17.0, _SMALL: 15.0, _TITLE: 22.0}  # height of a line of such letters
_WIDEST = 184.0  # of a line of text in a node
_NARROWEST_TITLE = 280.0
_PAD_X, _PAD_Y = 12.0, 7.0  # between a node's outline and its text
_GAP = (36.0, 12.0)  # between a node and its children, and between siblings
_APART = 10.0  # further between nodes below each other that are no siblings
_MARGIN = 20.0
_ICON = 20.0  # room for a sign before a name, or a mark behind it
_LABEL_PAD = 8.0  # around a label on an edge
_PORT = _PAD_Y + _LINE[_NAME] / 2  # from a node's upper side to where lines end: beside its name
_BEND = 8.0  # radius


class _Text(NamedTuple):
    """A line of text: what, in which letters, as which class of the style."""

    text: str
    size: float
    look: str

    @property
    def width(self) -> float:
        return text_width(self.text, self.size, bold=self.size != _SMALL)


@dataclass(frozen=True)
class _Block:
    """A node before it has a place: its lines of text, and the sign before its name."""

    lines: Sequence[_Text]
    sign: str
    marked: bool

    @property
    def indent(self) -> float:
        return _ICON if self.sign else 0.0

    @property
    def size(self) -> tuple[float, float]:
        name = self.indent + (_ICON if self.marked else 0.0)
        width = max(line.width + (name if line.size == _NAME else 0.0) for line in self.lines)
        return width + 2 * _PAD_X, sum(_LINE[line.size] for line in self.lines) + 2 * _PAD_Y


def svg_tree(
    tree: Tree | Outline,
    statuses: Mapping[str, Status] | None = None,
    feedback: Mapping[str, str] | None = None,
) -> str:
    """Return a tree as an SVG picture, for light and for dark pages.

    Args:
        tree: the tree, or what is drawn of it.
        statuses: node path to status; colours and marks the nodes if given.
        feedback: node path to what the node says; shown in it.
    """
    outline = outline_of(tree)
    blocks = [_block(node, statuses is not None, (feedback or {}).get(node.path, "")) for node in outline.nodes]
    labels = [_Text(node.branch, _SMALL, "branch") if node.branch else None for node in outline.nodes]
    room = [label.width + 2 * _LABEL_PAD if label else 0.0 for label in labels]
    boxes = tidy([node.parent for node in outline.nodes], [block.size for block in blocks], _GAP, room, _APART)
    right, bottom = max(box.right for box in boxes), max(box.bottom for box in boxes)
    title = _title(outline, max(right, _NARROWEST_TITLE))
    top = sum(_LINE[line.size] for line in title) + _PAD_X
    width = max(right, *(line.width for line in title)) + 2 * _MARGIN
    height = top + bottom + 2 * _MARGIN
    classes = [_status_class(node, statuses) for node in outline.nodes]
    turns = _turns([node.parent for node in outline.nodes], boxes, room)
    edges = []
    for index in sorted(range(1, len(boxes)), key=lambda index: classes[index] == "running"):  # these on top
        parent = outline.nodes[index].parent
        edges += _edge(boxes[parent], turns[parent], boxes[index], labels[index], classes[index])
    nodes = [
        line
        for node, block, box, status in zip(outline.nodes, blocks, boxes, classes, strict=True)
        for line in _node(node, block, box, status)
    ]
    size = f'width="{width:.0f}" height="{height:.0f}" viewBox="0 0 {width:.0f} {height:.0f}"'
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" {size} role="img">',
            f"<title>{escape(outline.name)}</title>",
            f"<style>\n{STYLE}</style>",
            '<rect class="paper" width="100%" height="100%" rx="8"/>',
            f'<g transform="translate({_MARGIN:g} {_MARGIN:g})">',
            *_texts(title, 0.0, 0.0),
            f'<g transform="translate(0 {top:g})">',
            *edges,
            *nodes,
            "</g>\n</g>\n</svg>\n",
        ]
    )


def _block(node: OutlineNode, marked: bool, feedback: str) -> _Block:
    sign = shapes.SIGNS.get(node.type_name, "")
    lines = _wrapped(node.name, _NAME, "name")
    if node.type_label:
        lines += _wrapped(node.type_name, _SMALL, "type")
    for parameter in node.parameters:
        lines += _wrapped(parameter, _SMALL, "small")
    if feedback:
        lines += _wrapped(one_line(feedback), _SMALL, "said")
    return _Block(lines, sign, marked)


def _title(outline: Outline, room: float) -> list[_Text]:
    lines = [_Text(line, _TITLE, "title") for line in wrap(outline.name, room, _TITLE, bold=True)]
    return lines + [_Text(line, _SMALL, "small") for line in wrap(outline.description, room, _SMALL) if line]


def _wrapped(text: str, size: float, look: str) -> list[_Text]:
    return [_Text(line, size, look) for line in wrap(text, _WIDEST, size, bold=size == _NAME)]


def _status_class(node: OutlineNode, statuses: Mapping[str, Status] | None) -> str:
    return "" if statuses is None else statuses.get(node.path, Status.INVALID).name.lower()


def _node(node: OutlineNode, block: _Block, box: Box, status: str) -> list[str]:
    kind = node.kind if node.kind in LOOKS else "other"
    parts = [
        f'<g class="{" ".join(filter(None, ("node", kind, status)))}" transform="translate({_at(box.x, box.y)})">',
        f"<title>{escape(node.hint)}</title>",
        *shapes.outline(look_of(node.kind).shape, box.width, box.height),
    ]
    if block.sign:
        parts.append(f'<path class="sign" transform="translate({_at(_PAD_X + 6, _PORT)})" d="{block.sign}"/>')
    if status:
        mark = shapes.MARKS[status]
        parts.append(f'<path class="mark" transform="translate({_at(box.width - _PAD_X - 3, _PORT)})" d="{mark}"/>')
    return [*parts, *_texts(block.lines, _PAD_X, _PAD_Y, block.indent), "</g>"]


def _texts(lines: Sequence[_Text], x: float, y: float, indent: float = 0.0) -> list[str]:
    """Return lines of text below each other, names behind a sign."""
    parts = []
    for line in lines:
        baseline = y + 0.5 * _LINE[line.size] + 0.35 * line.size
        at = x + (indent if line.size == _NAME else 0.0)
        parts.append(f'<text class="{line.look}" x="{at:g}" y="{baseline:.1f}">{escape(line.text)}</text>')
        y += _LINE[line.size]
    return parts


def _turns(parents: Sequence[int], boxes: Sequence[Box], room: Sequence[float]) -> dict[int, float]:
    """Return the x at which the lines from each node to its children turn."""
    turns: dict[int, float] = {}
    for parent, box, needed in zip(parents, boxes, room, strict=True):
        turn = box.x - needed - _GAP[0] / 2
        turns[parent] = min(turn, turns.get(parent, turn))
    return turns


def _edge(parent: Box, turn: float, child: Box, label: _Text | None, status: str) -> list[str]:
    """Return the line from a node's name to a child's: across, down, across."""
    start, end = parent.y + _PORT, child.y + _PORT
    path = f"M{_at(parent.right, start)}"
    if end > start:
        path += f"H{turn - _BEND:.1f}q{_BEND:g} 0 {_BEND:g} {_BEND:g}V{end - _BEND:.1f}q0 {_BEND:g} {_BEND:g} {_BEND:g}"
    kind = " ".join(filter(None, ("edge", "aside" if label else "", status)))
    parts = [f'<path class="{kind}" d="{path}H{child.x:.1f}"/>']
    if label:
        x = child.x - _LABEL_PAD - label.width
        parts.append(f'<text class="branch" x="{x:.1f}" y="{end - 5:.1f}">{escape(label.text)}</text>')
    return parts


def _at(x: float, y: float) -> str:
    return f"{x:.1f} {y:.1f}"
