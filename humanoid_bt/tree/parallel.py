"""Parallel: children side by side, with thresholds for success and failure."""

from __future__ import annotations

from collections.abc import Sequence as SequenceOf
from typing import Any, Literal

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from humanoid_bt.params import assign, param
from humanoid_bt.tree.ticking import FAILURE, RUNNING, SUCCESS, Branch, Seen, halt, tick

Threshold = Literal["all", "one"] | int


class Parallel(Branch, py_trees.composites.Parallel):
    """Run all children at once until enough of them succeeded or failed.

    Children that ended are not ticked again. If both thresholds are reached in one tick, it fails; so it does when
    every child has ended and too few succeeded.
    """

    success: Threshold = param("all", minimum=1, doc="How many children must succeed: all, one or a number.")
    failure: Threshold = param("one", minimum=1, doc="How many children must fail: all, one or a number.")

    def __init__(self, name: str, children: SequenceOf[Behaviour], **values: Any) -> None:
        super().__init__(name, policy=ParallelPolicy.SuccessOnAll(synchronise=True), children=children)
        assign(self, values)
        self._successes_needed = self._number("success", self.success)
        self._failures_needed = self._number("failure", self.failure)
        self._ended: set[Behaviour] = set()

    def setup(self, **kwargs: Any) -> None:
        """Nothing to set up: the thresholds were checked when the node was made."""

    def initialise(self) -> None:
        """Start every child afresh."""
        self._ended.clear()

    def advance(self, seen: Seen) -> Status:
        """Tick the children that have not ended; at the end, halt those that still run."""
        children, ended = self.children, self._ended
        for child in children:
            if child not in ended and tick(child, seen) is not RUNNING:
                ended.add(child)
        succeeded = sum(child.status is SUCCESS for child in ended)
        failed = len(ended) - succeeded
        self.current_child = children[-1]
        if failed >= self._failures_needed:
            self.feedback_message = f"{failed} of {len(children)} failed"
            status = FAILURE
        elif succeeded >= self._successes_needed:
            self.feedback_message = f"{succeeded} of {len(children)} succeeded"
            status = SUCCESS
        elif len(ended) == len(children):
            self.feedback_message = f"all ended, {succeeded} of {self._successes_needed} needed succeeded"
            status = FAILURE
        else:
            return RUNNING
        for child in children:
            if child.status is RUNNING:
                halt(child, f"{self.name!r} {'succeeded' if status is SUCCESS else 'failed'}", seen)
        self.current_child = next(child for child in reversed(children) if child.status is status)
        return status

    def _number(self, what: str, threshold: str | int) -> int:
        count = len(self.children)
        number = {"all": count, "one": 1}.get(threshold) if isinstance(threshold, str) else threshold
        if number is None or number > count:
            raise ValueError(f"{what!r} needs {threshold} of {count} children")
        return number
