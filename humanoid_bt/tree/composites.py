"""Sequence and selector: reactive by default, with memory where a tree says so."""

from __future__ import annotations

from collections.abc import Sequence as SequenceOf
from typing import Any

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.params import assign, param
from humanoid_bt.tree.ticking import FAILURE, INVALID, RUNNING, SUCCESS, Branch, Seen, halt, tick

_DID = {SUCCESS: "succeeded", FAILURE: "failed", RUNNING: "runs"}


class Sequence(Branch, py_trees.composites.Sequence):
    """Run the children in order while they succeed; fail with the first that fails."""

    memory: bool = param(False, doc="Go on at the RUNNING child instead of checking the earlier ones again.")

    def __init__(self, name: str, children: SequenceOf[Behaviour], **values: Any) -> None:
        super().__init__(name, memory=False, children=children)
        assign(self, values)

    def initialise(self) -> None:
        """Start with the first child."""
        self.current_child = None

    def advance(self, seen: Seen) -> Status:
        """Tick children until one does not succeed."""
        return _first_not(SUCCESS, self, seen)


class Selector(Branch, py_trees.composites.Selector):
    """Try the children in order until one succeeds or runs; fail if all fail."""

    memory: bool = param(False, doc="Go on at the RUNNING child instead of trying the earlier ones again.")

    def __init__(self, name: str, children: SequenceOf[Behaviour], **values: Any) -> None:
        super().__init__(name, memory=False, children=children)
        assign(self, values)

    def initialise(self) -> None:
        """Start with the first child."""
        self.current_child = None

    def advance(self, seen: Seen) -> Status:
        """Tick children until one does not fail."""
        return _first_not(FAILURE, self, seen)


def _first_not(passed: Status, node: Sequence | Selector, seen: Seen) -> Status:
    """Tick children in order up to the first whose status is not ``passed``; what ran behind it is preempted."""
    children = node.children
    before = node.current_child
    start = children.index(before) if node.memory and before is not None else 0
    status = passed
    for index in range(start, len(children)):
        child = children[index]
        status = tick(child, seen)
        if status is not passed:
            for later in children[index + 1 :]:
                if later.status is not INVALID:
                    halt(later, f"preempted by {child.name!r}, which {_DID[status]}", seen)
            break
    node.current_child = child
    return status
