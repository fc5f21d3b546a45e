"""Decorators that change how one child runs: inverter, retry, repeat, timeout."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.clock import Clock
from humanoid_bt.core.params import param
from humanoid_bt.core.units import readable
from humanoid_bt.decision.assign import assign
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.nodes.family import child_of
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS, Branch, Seen, halt, tick

TIME_TOLERANCE = 1e-9
"""Times within this of a limit count as at the limit [s]: engine times are sums and differences of floats."""


class Decorator(Branch, py_trees.decorators.Decorator):
    """Base of the nodes with one child."""

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child_of(type(self), name, child))
        assign(self, values)

    def asks_again(self, child: Behaviour) -> bool:
        """Return False: when the child has ended, it is started once more."""
        return False

    def reset_child(self, reason: str, seen: Seen) -> None:
        """Halt the child if it runs, and take away what it came to the last time."""
        if self.decorated.status is not INVALID:
            halt(self.decorated, reason, seen)


class Inverter(Decorator):
    """Turn success into failure and failure into success."""

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, swapped."""
        swapped = {SUCCESS: FAILURE, FAILURE: SUCCESS}
        return frozenset(swapped.get(status, status) for status in below.child)

    def advance(self, seen: Seen) -> Status:
        """Tick the child and swap its result."""
        status = tick(self.decorated, seen)
        if status is RUNNING:
            return status
        self.feedback_message = f"its child {'succeeded' if status is SUCCESS else 'failed'}"
        return FAILURE if status is SUCCESS else SUCCESS


class Retry(Decorator):
    """Try the child again when it fails, one attempt per tick."""

    attempts: int = param(minimum=-1, doc="How many attempts at most; -1 for ever.")

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self.check_values()
        self._failures = 0

    def check_values(self) -> None:
        """Refuse no attempt at all."""
        _not_zero("attempts", self.attempts)

    @classmethod
    def possible_results(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results; a failure that is tried again is RUNNING."""
        return _again(below.child, FAILURE, values["attempts"])

    @classmethod
    def results_at_once(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's, but for a failure that is tried again."""
        return below.child if values["attempts"] == 1 else below.child - {FAILURE}

    def initialise(self) -> None:
        """Start to count."""
        self._failures = 0

    def advance(self, seen: Seen) -> Status:
        """Tick the child; a failure is one attempt."""
        status = tick(self.decorated, seen)
        if status is SUCCESS:
            self.feedback_message = f"succeeded in attempt {_of(self._failures + 1, self.attempts)}"
        if status is not FAILURE:
            return status
        self._failures += 1
        self.feedback_message = f"attempt {_of(self._failures, self.attempts)} failed"
        return FAILURE if _reached(self._failures, self.attempts) else RUNNING


class Repeat(Decorator):
    """Run the child again when it succeeds, one run per tick; fail when it fails."""

    times: int = param(-1, minimum=-1, doc="How many successes; -1 for ever.")

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self.check_values()
        self._successes = 0

    def check_values(self) -> None:
        """Refuse no run at all."""
        _not_zero("times", self.times)

    @classmethod
    def possible_results(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results; a success after which it runs again is RUNNING."""
        return _again(below.child, SUCCESS, values["times"])

    @classmethod
    def results_at_once(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's, but for a success after which it runs again."""
        return below.child if values["times"] == 1 else below.child - {SUCCESS}

    def initialise(self) -> None:
        """Start to count."""
        self._successes = 0

    def advance(self, seen: Seen) -> Status:
        """Tick the child; a success is one time."""
        status = tick(self.decorated, seen)
        if status is not SUCCESS:
            return status
        self._successes += 1
        self.feedback_message = f"done {_of(self._successes, self.times)}"
        return SUCCESS if _reached(self._successes, self.times) else RUNNING


class Timeout(Decorator):
    """Halt the child and fail when it runs for too long."""

    limits_time: ClassVar[bool] = True
    """Whether what stands below is halted after some time."""

    duration: float = param(above=0, unit="s", doc="How long the child may run.")

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self._clock: Clock
        self._started = 0.0

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, and FAILURE if it may run."""
        return below.child | {FAILURE} if RUNNING in below.child else below.child

    def setup(self, **kwargs: Any) -> None:
        """Take the engine's clock, from ``robot``."""
        robot: Robot = kwargs["robot"]
        self._clock = robot.clock

    def initialise(self) -> None:
        """Start to measure."""
        self._started = self._clock.now()
        self.feedback_message = ""

    def advance(self, seen: Seen) -> Status:
        """Tick the child unless its time is up."""
        elapsed = self._clock.now() - self._started
        if elapsed < self.duration - TIME_TOLERANCE:
            return tick(self.decorated, seen)
        timed_out = f"timed out after {readable(elapsed, 's')}"
        self.feedback_message = f"{timed_out} (limit {readable(self.duration, 's')})"
        self.reset_child(timed_out, seen)
        return FAILURE


def _again(child: Results, repeated: Status, limit: int) -> Results:
    """Return the results of a node that runs its child again upon one of the child's results."""
    if repeated not in child or limit == 1:
        return child
    return (child if limit != -1 else child - {repeated}) | {RUNNING}


def _not_zero(name: str, count: int) -> None:
    if count == 0:
        raise ValueError(f"{name!r} must be at least 1, or -1 for ever")


def _reached(count: int, limit: int) -> bool:
    return 0 < limit <= count  # a limit that was set while the node runs may be behind


def _of(count: int, limit: int) -> str:
    return f"{count} of {limit}" if count <= limit else str(count)
