"""Parallel: children side by side, with thresholds for success and failure."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as SequenceOf
from typing import Any, Literal

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import ParallelPolicy, Status

from humanoid_bt.core.params import param
from humanoid_bt.decision.assign import assign
from humanoid_bt.tree.nodes.family import children_of
from humanoid_bt.tree.results import NOTHING, Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, RUNNING, SUCCESS, Branch, Seen, halt, tick

Threshold = Literal["all", "one"] | int


class Parallel(Branch, py_trees.composites.Parallel):
    """Run all children at once until enough of them succeeded or failed.

    Children that ended are not ticked again. If both thresholds are reached in one tick, it fails; so it does when
    every child has ended and too few succeeded.
    """

    success: Threshold = param("all", minimum=1, doc="How many children must succeed: all, one or a number.")
    failure: Threshold = param("one", minimum=1, doc="How many children must fail: all, one or a number.")

    def __init__(self, name: str, children: SequenceOf[Behaviour], **values: Any) -> None:
        children = children_of(type(self), name, children)
        super().__init__(name, policy=ParallelPolicy.SuccessOnAll(synchronise=True), children=children)
        assign(self, values)
        self.check_values()
        self._ended: set[Behaviour] = set()

    def check_values(self) -> None:
        """Refuse a threshold beyond the number of children."""
        count = len(self.children)
        for what, threshold in (("success", self.success), ("failure", self.failure)):
            if isinstance(threshold, int) and threshold > count:
                raise ValueError(f"{what!r} needs {threshold} of {count} children")

    @classmethod
    def possible_results(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return what the children's results can add up to."""
        children = below.children
        successes, failures = (number_of(values[what], len(children)) for what in ("success", "failure"))
        can_succeed = sum(SUCCESS in child for child in children)
        found = {RUNNING} if any(RUNNING in child for child in children) else set()
        if can_succeed >= successes:
            found.add(SUCCESS)
        all_can_end = all(child & {SUCCESS, FAILURE} for child in children)
        too_few = sum(FAILURE not in child for child in children) < successes
        if sum(FAILURE in child for child in children) >= failures or (all_can_end and too_few):
            found.add(FAILURE)
        return frozenset(found)

    @classmethod
    def results_at_once(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return what the children's add up to, if all can answer at once: it starts every one."""
        return cls.possible_results(values, below) if all(below.children) else NOTHING

    def setup(self, **kwargs: Any) -> None:
        """Nothing to set up: the thresholds were checked when the node was made."""

    def initialise(self) -> None:
        """Start every child afresh."""
        self._ended.clear()

    def advance(self, seen: Seen) -> Status:
        """Tick the children that have not ended; at the end, halt those that still run."""
        children, ended = self.children, self._ended
        for child in children:
            if child in ended:
                continue
            if tick(child, seen) is RUNNING:
                self.current_child = child
            else:
                ended.add(child)
        succeeded = sum(child.status is SUCCESS for child in ended)
        failed = len(ended) - succeeded
        needed = number_of(self.success, len(children))
        if failed >= number_of(self.failure, len(children)):
            self.feedback_message = f"{failed} of {len(children)} failed"
            status = FAILURE
        elif succeeded >= needed:
            self.feedback_message = f"{succeeded} of {len(children)} succeeded"
            status = SUCCESS
        elif len(ended) == len(children):
            self.feedback_message = f"all ended, {succeeded} of {needed} needed succeeded"
            status = FAILURE
        else:
            return RUNNING
        for child in children:
            if child.status is RUNNING:
                halt(child, f"{self.name!r} {'succeeded' if status is SUCCESS else 'failed'}", seen)
        self.current_child = next(child for child in reversed(children) if child.status is status)
        return status


def number_of(threshold: Threshold, count: int) -> int:
    """Return how many of some children a threshold means."""
    return {"all": count, "one": 1}[threshold] if isinstance(threshold, str) else threshold
