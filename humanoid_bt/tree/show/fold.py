"""Trees in less room: branches that are folded, and of a tree that runs what is at work, and the way there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import replace
from itertools import groupby

from py_trees.common import Status

from humanoid_bt.tree.show.outline import Outline, OutlineNode

Statuses = Mapping[str, Status]
"""Node path to status."""

_IDLE = {Status.INVALID}
_AT_REST = {Status.INVALID, Status.SUCCESS, Status.FAILURE}


def folded_below(outline: Outline, depth: int) -> Outline:
    """Return a tree with what is deeper than a depth folded; the root's depth is 1."""
    depths: dict[str, int] = {}
    for node in outline.nodes:
        depths[node.path] = depths[outline.nodes[node.parent].path] + 1 if node.parent >= 0 else 1
    return _counted(outline, lambda node: depths[node.path] >= depth)


def without_subtrees(outline: Outline) -> Outline:
    """Return a tree with what is in its sub-trees folded."""
    return _counted(outline, lambda node: node.kind == "subtree")


def fitted(outline: Outline, statuses: Statuses, fits: Callable[[Outline], bool]) -> Outline:
    """Return a tree with as much of it folded as it takes to fit; what runs is always in it.

    First what is below idle nodes is counted instead of drawn, then what is below all that do not run. Then a node
    and its only child share a line, and so do siblings at rest. Then only what runs is left, and at last the lowest of
    it, below a line that says what is missing.

    Args:
        outline: the tree.
        statuses: of all its nodes.
        fits: whether there is room for a tree.
    """
    for smaller in _ever_smaller(outline, statuses):
        outline = smaller
        if fits(outline):
            break
    return outline


def _ever_smaller(outline: Outline, statuses: Statuses) -> Iterator[Outline]:
    yield outline
    yield _counted(outline, lambda node: statuses[node.path] in _IDLE)
    outline = _counted(outline, lambda node: statuses[node.path] in _AT_REST)
    yield outline
    outline = _chained(outline, statuses)
    yield outline
    outline = _grouped(outline, statuses)
    yield outline
    outline = _chained(_running(outline, statuses), statuses)
    yield outline
    for count in range(len(outline.nodes) - 1, 1, -1):
        yield _lowest(outline, count)


def _lowest(outline: Outline, count: int) -> Outline:
    """Return at most this many nodes of a tree: the last that a reader meets, below one that says what is missing."""
    order = outline.in_order()
    if len(order) <= count:
        return outline
    kept = order[len(order) - count + 1 :]
    place = {index: number for number, index in enumerate(kept, start=1)}
    above = replace(outline.nodes[0], name=f"{len(order) - len(kept)} more above", parameters=())
    nodes = [replace(outline.nodes[index], parent=place.get(outline.nodes[index].parent, 0)) for index in kept]
    return replace(outline, nodes=(replace(above, type_name=above.name), *nodes))


def _counted(outline: Outline, closed: Callable[[OutlineNode], bool]) -> Outline:
    """Return the tree with what is below closed nodes counted instead of drawn."""
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


def _chained(outline: Outline, statuses: Statuses) -> Outline:
    """Return the tree with each node on one line with its only child, if they have the same status."""
    children = outline.children()
    kept: list[OutlineNode] = []
    place: list[int] = []
    for index, node in enumerate(outline.nodes):
        parent = node.parent
        alone = parent >= 0 and children[parent] == [index]
        if alone and statuses[outline.nodes[parent].path] is statuses[node.path]:
            place.append(place[parent])
            above = kept[place[parent]]
            name = f"{above.name} / {node.title}"
            kept[place[parent]] = replace(node, name=name, type_name=name, parent=above.parent, branch=above.branch)
        else:
            place.append(len(kept))
            kept.append(replace(node, parent=place[parent] if parent >= 0 else -1))
    return replace(outline, nodes=tuple(kept))


def _grouped(outline: Outline, statuses: Statuses) -> Outline:
    """Return the tree with siblings at rest on one line, where they follow each other and have the same status."""
    children = outline.children()
    names: dict[int, str] = {}  # of each first of such siblings
    gone: set[int] = set()
    for siblings in children:
        leaves = ((statuses[outline.nodes[index].path], bool(children[index])) for index in siblings)
        for (status, inner), pairs in groupby(zip(leaves, siblings, strict=True), key=lambda pair: pair[0]):
            group = [index for _, index in pairs]
            if len(group) > 1 and not inner and status is not Status.RUNNING:
                names[group[0]] = ", ".join(outline.nodes[index].title for index in group)
                gone |= set(group[1:])
    nodes = [
        replace(node, name=names[index], type_name=names[index], branch="", parameters=()) if index in names else node
        for index, node in enumerate(outline.nodes)
    ]
    return _without(replace(outline, nodes=tuple(nodes)), gone)


def _running(outline: Outline, statuses: Statuses) -> Outline:
    """Return the tree without what does not run, apart from its root."""
    return _without(outline, {i for i, node in enumerate(outline.nodes) if i and statuses[node.path] in _AT_REST})


def _without(outline: Outline, gone: Container[int]) -> Outline:
    """Return the tree without some nodes, which must have no others below them."""
    place: dict[int, int] = {-1: -1}
    kept: list[OutlineNode] = []
    for index, node in enumerate(outline.nodes):
        if index not in gone:
            place[index] = len(kept)
            kept.append(replace(node, parent=place[node.parent]))
    return replace(outline, nodes=tuple(kept))
