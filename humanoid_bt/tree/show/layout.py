"""Where the nodes of a drawn tree go: depth to the right, siblings below each other, in a tree's order."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple


class Box(NamedTuple):
    """A node's place: its left upper corner, with y downwards, and its size."""

    x: float
    y: float
    width: float
    height: float

    @property
    def right(self) -> float:
        """X of its right side."""
        return self.x + self.width

    @property
    def bottom(self) -> float:
        """Y of its lower side."""
        return self.y + self.height


def tidy(
    parents: Sequence[int],
    sizes: Sequence[tuple[float, float]],
    gap: tuple[float, float],
    room: Sequence[float] | None = None,
    apart: float = 0.0,
) -> list[Box]:
    """Return a box per node, none of which overlap, as close together as their order allows.

    Nodes of one depth start at one x, in the tree's order from top to bottom. A first child stands at its parent's
    height, so that the root is where a reader begins, and a lower child below all that came before at its depth.

    Args:
        parents: each node's parent, -1 for the root; nodes come in the order in which a tree is read.
        sizes: each node's width and height.
        gap: least free space between a node and its children, and between two nodes below each other.
        room: further space to keep free on each node's left, for a label on its edge.
        apart: further space between two nodes below each other that have different parents.
    """
    depths = _depths(parents)
    starts = _starts(depths, [width for width, _ in sizes], gap[0], room or [0.0] * len(parents))
    free = [0.0] * len(starts)  # y from which there is nothing at each depth
    owner = [-1] * len(starts)  # parent of the lowest node at each depth
    y = [0.0] * len(parents)
    for line in _lines(parents):
        top = 0.0
        for index in line:
            depth = depths[index]
            top = max(top, free[depth] + (apart if free[depth] and owner[depth] != parents[index] else 0.0))
        for index in line:
            y[index] = top
            free[depths[index]], owner[depths[index]] = top + sizes[index][1] + gap[1], parents[index]
    return [Box(starts[depths[index]], y[index], *size) for index, size in enumerate(sizes)]


def _lines(parents: Sequence[int]) -> list[list[int]]:
    """Return which nodes stand at one height: one that is no first child, its first child, that one's, and so on."""
    lines: list[list[int]] = []
    line_of: dict[int, list[int]] = {}  # of each node that has no child yet
    for index, parent in enumerate(parents):
        line = line_of.pop(parent, None)
        if line is None:
            line = []
            lines.append(line)
        line.append(index)
        line_of[index] = line
    return lines


def _depths(parents: Sequence[int]) -> list[int]:
    depths: list[int] = []
    for parent in parents:
        depths.append(depths[parent] + 1 if parent >= 0 else 0)
    return depths


def _starts(depths: Sequence[int], widths: Sequence[float], gap: float, room: Sequence[float]) -> list[float]:
    """Return where the nodes of each depth start."""
    columns = [0.0] * (max(depths, default=-1) + 1)
    rooms = list(columns)
    for depth, width, needed in zip(depths, widths, room, strict=True):
        columns[depth] = max(columns[depth], width)
        rooms[depth] = max(rooms[depth], needed)
    starts = rooms[:1]
    for depth in range(1, len(columns)):
        starts.append(starts[-1] + columns[depth - 1] + gap + rooms[depth])
    return starts
