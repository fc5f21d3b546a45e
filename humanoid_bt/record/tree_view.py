"""The tree as it runs: a line per node, as ``humanoid-bt show`` draws it, in the colours of their statuses."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import rerun as rr
from py_trees.common import Status

from humanoid_bt.core.errors import HumanoidBtError, nearest
from humanoid_bt.record.columns import Color, send_sets
from humanoid_bt.record.names import with_subtree_names
from humanoid_bt.tree.show.fold import fitted
from humanoid_bt.tree.show.looks import MARKS, STATUS_COLORS
from humanoid_bt.tree.show.metrics import text_width
from humanoid_bt.tree.show.outline import Outline

TREE = "tree"
EDGES, BOXES, LABELS = f"{TREE}/edges", f"{TREE}/boxes", f"{TREE}/labels"

# One unit is one pixel in a window of 1920x1080. There the drawing fills its view, and it never grows: the viewer's
# labels have one size on the screen, and neither they nor a drawing that is larger than the view can be read.
SIZE = (940.0, 400.0)
BACKGROUND: Color = (0, 0, 0)

_ROW, _HEIGHT = 28.0, 24.0  # distance of lines below each other; height of a box
_INDENT = 24.0  # of a child to its parent
_PAD = 9.0  # between a box and its text
_LETTERS = 13.6  # size at which text of this package's metrics is as wide as the viewer's labels
_DROP = 13.0  # from where the viewer is told to put a label down to the label's middle
_GAP = " " * 6  # between the name of a node and what stands beside it
_ROOM = int((SIZE[1] + _ROW - _HEIGHT) // _ROW)  # lines
_INK: Color = (255, 255, 255)

_GLYPHS = frozenset("✓✗▶●○→")  # beyond ASCII the viewer's font has few glyphs, and some missing ones crash it


def printable(text: str) -> str:
    """Return a text with only the characters that the viewer can draw."""
    return "".join(c if c in _GLYPHS or " " <= c <= "~" or c == "\n" else "?" for c in text)


@dataclass
class _Picture:
    """What is drawn from a time on."""

    time: float
    boxes: list[tuple[float, float, float]] = field(default_factory=list)  # left, middle line, width
    box_colors: list[Color] = field(default_factory=list)
    edges: list[list[tuple[float, float]]] = field(default_factory=list)
    edge_colors: list[Color] = field(default_factory=list)
    labels: list[str] = field(default_factory=list)
    places: list[tuple[float, float]] = field(default_factory=list)

    def write(self, left: float, middle: float, text: str) -> None:
        """Add a label that begins at a place, cut to the drawing's width."""
        width = text_width(text, _LETTERS)
        if left + width > SIZE[0]:
            room = SIZE[0] - left
            fits = bisect_right(range(1, len(text)), room, key=lambda count: text_width(text[:count] + "...", _LETTERS))
            text = text[:fits] + "..."
            width = text_width(text, _LETTERS)
        self.labels.append(text)
        self.places.append((left + width / 2, middle - _DROP))


class TreeStatus:
    """Draws a tree and its nodes' status, folded to fit; another tree may take its place."""

    def __init__(self, outline: Outline) -> None:
        self._pictures: list[_Picture] = []
        self._take(outline)

    def _take(self, outline: Outline) -> None:
        self._outline = with_subtree_names(outline)
        self._status = {node.path: Status.INVALID for node in outline.nodes}
        self._said: dict[str, str] = {}
        self._changed: float | None = None  # time of changes that are in no picture yet

    def log_static(self, stream: Any) -> None:
        """Write the tree as it is at the start, and what does not change in its looks."""
        stream.log(EDGES, rr.LineStrips2D.from_fields(radii=-1.0), static=True)
        stream.log(BOXES, rr.Boxes2D.from_fields(radii=-1.0, show_labels=False), static=True)
        stream.log(LABELS, rr.Points2D.from_fields(radii=0.0, colors=_INK, show_labels=True), static=True)
        self._changed = 0.0
        self.flush(stream)

    def show(self, time: float, outline: Outline) -> None:
        """Take another tree, which takes the place of the one so far from a time on [s]."""
        self._draw()
        self._take(outline)
        self._changed = time

    def change(self, time: float, path: str, status: str, feedback: str) -> None:
        """Take a node's change of status, in the order of time.

        Raises:
            HumanoidBtError: there is no such node or status.
        """
        if path not in self._status:
            raise HumanoidBtError(f"the tree has no node {path!r}; {nearest(path, self._status)}")
        if status not in Status.__members__:
            raise HumanoidBtError(f"no status {status!r}; {nearest(status, Status.__members__)}")
        if self._changed != time:
            self._draw()
        self._status[path], self._said[path] = Status[status], feedback
        self._changed = time

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        self._draw()
        if self._pictures:
            _send(stream, self._pictures)
            self._pictures = []

    def _draw(self) -> None:
        """Draw the tree as it is, if it has changed."""
        if self._changed is None:
            return
        picture = _Picture(self._changed)
        self._changed = None
        outline = fitted(self._outline, self._status, lambda tree: len(tree.nodes) <= _ROOM)
        places: dict[int, tuple[float, float]] = {}
        edges: list[tuple[bool, list[tuple[float, float]], Color]] = []
        for row, index in enumerate(outline.in_order()):
            node = outline.nodes[index]
            status = self._status[node.path]
            color = STATUS_COLORS[status.name].dark
            middle = row * _ROW + _HEIGHT / 2
            left = places[node.parent][0] + _INDENT if node.parent >= 0 else 0.0
            places[index] = (left, middle)
            name = printable(" ".join(filter(None, (MARKS[status], node.title, node.type_label))))
            aside = printable(self._aside(node.path, status, node.parameters))
            # One label a line: in a smaller window, where labels keep their size, two of them would meet.
            picture.write(left + _PAD, middle, name + (_GAP + aside if aside else ""))
            picture.boxes.append((left, middle, text_width(name, _LETTERS) + 2 * _PAD))
            picture.box_colors.append(color)
            if node.parent >= 0:
                start, above = places[node.parent]
                start += _INDENT / 2
                line = [(start, above + _HEIGHT / 2), (start, middle), (left, middle)]
                edges.append((status is Status.RUNNING, line, color))
        for _, line, color in sorted(edges, key=lambda edge: edge[0]):  # what runs on top
            picture.edges.append(line)
            picture.edge_colors.append(color)
        self._pictures.append(picture)

    def _aside(self, path: str, status: Status, parameters: Sequence[str]) -> str:
        """Return what stands beside a node: why it ended, or else what it was given."""
        ended = status in (Status.SUCCESS, Status.FAILURE)
        return (self._said.get(path, "") if ended else "") or ", ".join(parameters)


def _send(stream: Any, pictures: Sequence[_Picture]) -> None:
    times = [picture.time for picture in pictures]
    boxes = [box for picture in pictures for box in picture.boxes]
    send_sets(
        stream,
        BOXES,
        times,
        rr.Boxes2D.columns(
            centers=[(left + width / 2, middle) for left, middle, width in boxes],
            half_sizes=[(width / 2, _HEIGHT / 2) for _, _, width in boxes],
            colors=[color for picture in pictures for color in picture.box_colors],
        ),
        [len(picture.boxes) for picture in pictures],
        lasting=True,
    )
    send_sets(
        stream,
        LABELS,
        times,
        rr.Points2D.columns(
            positions=[place for picture in pictures for place in picture.places],
            labels=[label for picture in pictures for label in picture.labels],
        ),
        [len(picture.labels) for picture in pictures],
        lasting=True,
    )
    send_sets(
        stream,
        EDGES,
        times,
        rr.LineStrips2D.columns(
            strips=[line for picture in pictures for line in picture.edges],
            colors=[color for picture in pictures for color in picture.edge_colors],
        ),
        [len(picture.edges) for picture in pictures],
        lasting=True,
    )
