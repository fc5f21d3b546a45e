"""Trees in less room: branches that are folded, and of a tree that runs the part where something happens."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from py_trees.common import Status

from humanoid_bt.tree.show.outline import Outline, OutlineNode
from humanoid_bt.tree.show.text import Line, lines_of


def folded(outline: Outline, closed: Callable[[OutlineNode], bool]) -> Outline:
    """Return a tree with what is below some nodes counted instead of drawn.

    Args:
        outline: the tree.
        closed: whether what is below a node is left out.
    """
    kept: list[OutlineNode] = []
    place: list[int] = []  # of each node in what is kept, or of the node that it is folded into
    hidden: Counter[int] = Counter()
    for node in outline.nodes:
        parent = node.parent
        if parent >= 0 and (place[parent] in hidden or closed(outline.nodes[parent])):
            hidden[place[parent]] += 1
            place.append(place[parent])
        else:
            place.append(len(kept))
            kept.append(replace(node, parent=place[parent] if parent >= 0 else -1))
    for index, count in hidden.items():
        kept[index] = replace(kept[index], parameters=(*kept[index].parameters, f"{count} below"))
    return replace(outline, nodes=tuple(kept))


def folded_below(outline: Outline, depth: int) -> Outline:
    """Return a tree with what is deeper than a depth folded; the root's depth is 1."""
    depths: dict[str, int] = {}
    for node in outline.nodes:
        depths[node.path] = depths[outline.nodes[node.parent].path] + 1 if node.parent >= 0 else 1
    return folded(outline, lambda node: depths[node.path] >= depth)


def without_subtrees(outline: Outline) -> Outline:
    """Return a tree with what is in its sub-trees folded."""
    return folded(outline, lambda node: node.kind == "subtree")


def fitted(
    outline: Outline, statuses: Mapping[str, Status], feedback: Mapping[str, str], width: int, height: int
) -> tuple[Outline, list[Line]]:
    """Return a tree that runs, and its lines, as far as they fit; what runs deepest is always among them.

    What is below idle nodes is folded where the tree is too tall, then what is below all that does not run; of what is
    still too tall the part around the deepest running node is left.

    Args:
        outline: the tree.
        statuses: node path to status.
        feedback: node path to what the node says.
        width, height: the room there is, in columns and lines.
    """

    def idle(node: OutlineNode) -> bool:
        return statuses.get(node.path, Status.INVALID) is Status.INVALID

    def resting(node: OutlineNode) -> bool:
        return statuses.get(node.path, Status.INVALID) is not Status.RUNNING

    shown, lines = outline, lines_of(outline, statuses, width, feedback)
    for closed in (idle, resting):
        if len(lines) > height:
            shown = folded(outline, closed)
            lines = lines_of(shown, statuses, width, feedback)
    return shown, lines if len(lines) <= height else _around(lines, _active(shown, statuses), height)


def _active(outline: Outline, statuses: Mapping[str, Status]) -> int:
    """Return the index of the last node that runs while nothing below it does; the root's if nothing runs."""
    running = [index for index, node in enumerate(outline.nodes) if statuses.get(node.path) is Status.RUNNING]
    parents = {outline.nodes[index].parent for index in running}
    return next((index for index in reversed(running) if index not in parents), 0)


def _around(lines: Sequence[Line], node: int, height: int) -> list[Line]:
    """Return the title and the lines around a node, with a word on how many are left out."""
    title, body = lines[0], [line for line in lines if line.node >= 0]
    room = max(height - 1, 3)
    own = [number for number, line in enumerate(body) if line.node == node]
    start = min(max(own[-1] - 2 * room // 3, 0), max(len(body) - room, 0))
    part = body[start : start + room]
    below = len(body) - start - len(part)
    if start:
        part[0] = Line(-1, f"... {start + 1} lines above", "")
    if below:
        part[-1] = Line(-1, f"... {below + 1} lines below", "")
    return [title, *part][:height]
