"""Sequence and selector: reactive by default, with memory where a tree says so."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as SequenceOf
from itertools import islice
from typing import Any, ClassVar

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.params import param
from humanoid_bt.decision.assign import assign
from humanoid_bt.tree.engine.ticking import FAILURE, INVALID, RUNNING, SUCCESS, Branch, Seen, halt, tick
from humanoid_bt.tree.results import Below, Results

_DID = {SUCCESS: "succeeded", FAILURE: "failed", RUNNING: "runs"}


class _Ordered(Branch):
    """Ticks its children in order up to the first whose status is not ``passed``."""

    passed: ClassVar[Status]
    """The status of a child with which the next one gets its turn."""

    memory: bool = param(False, doc="Go on at the RUNNING child instead of beginning with the first again.")

    def __init__(self, name: str, children: SequenceOf[Behaviour], **values: Any) -> None:
        # py_trees' own composite, which comes next in the order of classes, takes these
        super().__init__(name, memory=False, children=children)  # type: ignore[call-arg]
        assign(self, values)

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return what the children can answer, up to one that never lets the next have its turn."""
        found: set[Status] = set()
        for child in below.children:
            found |= child - {cls.passed}
            if cls.passed not in child:
                return frozenset(found)
        return frozenset(found | {cls.passed})

    def initialise(self) -> None:
        """Start with the first child."""
        self.current_child: Behaviour | None = None

    def advance(self, seen: Seen) -> Status:
        """Tick children in order; what ran behind the one that decides is preempted."""
        children, passed = iter(self.children), self.passed
        if self.memory and self.current_child is not None:
            children = islice(children, self.children.index(self.current_child), None)
        for child in children:
            status = tick(child, seen)
            if status is not passed:
                break
        for later in children:  # none, unless a child decided
            if later.status is not INVALID:
                halt(later, f"preempted by {child.name!r}, which {_DID[status]}", seen)
        self.current_child = child
        return status


class Sequence(_Ordered, py_trees.composites.Sequence):
    """Run the children in order while they succeed; fail with the first that fails."""

    passed = SUCCESS


class Selector(_Ordered, py_trees.composites.Selector):
    """Try the children in order until one succeeds or runs; fail if all fail."""

    passed = FAILURE
