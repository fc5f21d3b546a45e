"""Decorators that give another status than their child, keep it, or write it to the blackboard."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.params import param
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.nodes.decorators import Decorator
from humanoid_bt.tree.results import AT_ONCE, SUCCEEDS, Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS, Seen, tick


class Converter(Decorator):
    """Base of the decorators that put one status in the place of another.

    Attributes:
        becomes: the child's status to the decorator's; what is not in it stays as it is.
    """

    becomes: ClassVar[dict[Status, Status]]

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, converted."""
        return frozenset(cls.becomes.get(status, status) for status in below.child)

    def advance(self, seen: Seen) -> Status:
        """Tick the child and convert its status; what counts as ended is halted if it runs."""
        status = tick(self.decorated, seen)
        converted = self.becomes.get(status, status)
        self.feedback_message = "" if converted is status else f"its child {_DID[status]}"
        if status is RUNNING and converted is not RUNNING:
            self.reset_child(f"{self.name!r} takes running for {converted.name.lower()}", seen)
        return converted


_DID = {SUCCESS: "succeeded", FAILURE: "failed", RUNNING: "runs"}


class ForceSuccess(Converter):
    """Succeed when the child ends, also when it fails."""

    becomes: ClassVar = {FAILURE: SUCCESS}


class ForceFailure(Converter):
    """Fail when the child ends, also when it succeeds."""

    becomes: ClassVar = {SUCCESS: FAILURE}


class RunningIsFailure(Converter):
    """Fail when the child does not end in its first tick; it is halted then."""

    becomes: ClassVar = {RUNNING: FAILURE}
    limits_time: ClassVar[bool] = True


class RunningIsSuccess(Converter):
    """Succeed when the child does not end in its first tick; it is halted then."""

    becomes: ClassVar = {RUNNING: SUCCESS}
    limits_time: ClassVar[bool] = True


class FailureIsRunning(Converter):
    """Go on when the child fails: it starts again in the next tick, until it succeeds."""

    becomes: ClassVar = {FAILURE: RUNNING}
    bounded: ClassVar[bool] = False


class SuccessIsRunning(Converter):
    """Go on when the child succeeds: it starts again in the next tick, until it fails."""

    becomes: ClassVar = {SUCCESS: RUNNING}
    bounded: ClassVar[bool] = False


class Once(Decorator):
    """Run the child once, and give its result from then on without running it again.

    With the policy `success` only a success counts: a child that failed is started again the next time. A child that
    was halted has not ended, and is started again. The result is kept until the end of the run.
    """

    policy: Literal["completion", "success"] = param("completion", doc="What counts: any end, or only success.")

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self._result: Status | None = None

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results."""
        return below.child

    @classmethod
    def results_at_once(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return what it keeps, and what the child can answer at once."""
        return AT_ONCE if values["policy"] == "completion" else SUCCEEDS | below.child

    def advance(self, seen: Seen) -> Status:
        """Tick the child unless there is a result."""
        if self._result is not None:
            self.feedback_message = f"{_DID[self._result]} before"
            return self._result
        status = tick(self.decorated, seen)
        if status is SUCCESS or (status is FAILURE and self.policy == "completion"):
            self._result = status
        return status


class StatusToBlackboard(Decorator):
    """Run the child and write its status to a key of the blackboard, as a text.

    The texts are `running`, `success` and `failure`, and `invalid` when it is halted while it runs, or raises. A
    result stays until the child starts again. What is ticked after this node sees it in the same tick.
    """

    key: Key = param(doc="The key.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results."""
        return below.child

    def advance(self, seen: Seen) -> Status:
        """Tick the child and write its status."""
        status = INVALID
        try:
            status = tick(self.decorated, seen)
        finally:
            self.key.set(status.name.lower())
        return status

    def terminate(self, new_status: Status) -> None:
        """Write that it was halted."""
        if new_status is INVALID:
            self.key.set("invalid")
