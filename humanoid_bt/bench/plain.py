"""The same tree in plain py_trees, for comparison."""

from __future__ import annotations

from collections.abc import Callable

from py_trees import behaviours, composites, decorators
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from humanoid_bt.tree.node import Node
from humanoid_bt.tree.tree import Tree


def leaves(tree: Tree) -> list[Node]:
    """Return the nodes that have no nodes below them."""
    parents = {node.parent for node in tree.nodes}
    return [node for index, node in enumerate(tree.nodes) if index not in parents]


def empty_leaves(tree: Tree) -> None:
    """Let every leaf that was ticked do nothing but return its status again."""
    for leaf in leaves(tree):
        if leaf.behaviour.status is not Status.INVALID:
            leaf.behaviour.update = _constant(leaf.behaviour.status)  # type: ignore[method-assign]  # an empty leaf


def plain_copy(tree: Tree, *, same_leaves: bool = False) -> Behaviour:
    """Return a tree of py_trees' own nodes that ticks the nodes which a ticked tree has ticked.

    Sequences, selectors and parallels become py_trees' own. Of any other node the children that were ticked are left:
    one below a decorator that gives the same status, several in a selector or a sequence, whichever goes on as it did.

    Args:
        tree: the tree, ticked at least once.
        same_leaves: take the tree's own leaves, so that the tree must not be ticked any more. Else those of the copy
            do nothing but return the status that the tree's have.
    """
    below: dict[int, list[int]] = {}
    for index, node in enumerate(tree.nodes):
        below.setdefault(node.parent, []).append(index)

    def copy(index: int) -> Behaviour:
        node, children = tree.nodes[index], below.get(index, [])
        if not children:
            return _given_away(node.behaviour) if same_leaves else _fixed(node)
        return _composite(node, list(map(copy, children))) if _is_known(node) else passing_on(node, children)

    def passing_on(node: Node, children: list[int]) -> Behaviour:
        before = node.behaviour.status
        if before is Status.INVALID:
            return decorators.PassThrough(node.name, copy(children[0]))
        ticked = [child for child in children if tree.nodes[child].behaviour.status is not Status.INVALID]
        if not ticked:
            return _fixed(node)
        first = tree.nodes[ticked[0]].behaviour.status
        if len(ticked) == 1:
            return _decorator(before, first)(node.name, copy(ticked[0]))
        kind = composites.Selector if first is Status.FAILURE else composites.Sequence
        return kind(node.name, False, list(map(copy, ticked)))

    return copy(0)


def _is_known(node: Node) -> bool:
    return isinstance(node.behaviour, composites.Sequence | composites.Selector | composites.Parallel)


def _composite(node: Node, children: list[Behaviour]) -> Behaviour:
    match node.behaviour:
        case composites.Sequence(memory=memory):
            return composites.Sequence(node.name, memory, children)
        case composites.Selector(memory=memory):
            return composites.Selector(node.name, memory, children)
    return composites.Parallel(node.name, ParallelPolicy.SuccessOnAll(), children)


def _decorator(status: Status, child: Status) -> type[decorators.Decorator]:
    """Return the decorator that makes of its child's status what ours made of it."""
    if status is child:
        return decorators.PassThrough
    found: type[decorators.Decorator] = getattr(decorators, f"{child.name.title()}Is{status.name.title()}")
    return found


def _fixed(node: Node) -> Behaviour:
    status = node.behaviour.status
    leaf = behaviours.Dummy(node.name)
    leaf.update = _constant(Status.FAILURE if status is Status.INVALID else status)  # type: ignore[method-assign]  # an empty leaf
    return leaf


def _given_away(leaf: Behaviour) -> Behaviour:
    """Return a leaf as one that another parent takes."""
    leaf.parent = None
    return leaf


def _constant(status: Status) -> Callable[[], Status]:
    return lambda: status
