"""Decorators that measure time: delay, cooldown, min_duration."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.clock import Clock
from humanoid_bt.core.params import param
from humanoid_bt.core.units import readable
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.nodes.decorators import TIME_TOLERANCE, Decorator
from humanoid_bt.tree.results import NOTHING, Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, Seen, tick


class Timed(Decorator):
    """Base of the decorators that measure the engine's time."""

    def setup(self, **kwargs: Any) -> None:
        """Take the engine's clock, from ``robot``."""
        robot: Robot = kwargs["robot"]
        self._clock: Clock = robot.clock

    def left(self, duration: float, since: float) -> float:
        """Return how much is left of a duration [s] that began at a time [s]; 0 when it is over."""
        left = duration - (self._clock.now() - since)
        return left if left > TIME_TOLERANCE else 0.0


class Delay(Timed):
    """Wait for some time, then run the child.

    It waits each time it starts. A delay that is halted while it waits has not run its child.
    """

    duration: float = param(minimum=0, unit="s", doc="How long to wait.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, and RUNNING while it waits."""
        return below.child | {RUNNING}

    @classmethod
    def results_at_once(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return nothing: it takes its time."""
        return NOTHING

    def initialise(self) -> None:
        """Start to measure."""
        self._started = self._clock.now()
        self._over = False

    def advance(self, seen: Seen) -> Status:
        """Tick the child once the time is over."""
        if not self._over:
            left = self.left(self.duration, self._started)
            self._over = not left
            self.feedback_message = f"starts in {readable(round(left, 1), 's')}" if left else ""
            if left:
                self.reset_child("waiting to start", seen)
                return RUNNING
        return tick(self.decorated, seen)


class Cooldown(Timed):
    """Run the child, then fail for some time without running it.

    The time counts from when the child ended, however it did, or was halted. It goes on while the node is not ticked,
    and only the end of the run forgets it.
    """

    duration: float = param(minimum=0, unit="s", doc="How long the child does not run again.")

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self._last: float | None = None  # when the child ran last

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, and FAILURE while it cools down."""
        return below.child | {FAILURE}

    def advance(self, seen: Seen) -> Status:
        """Tick the child unless it is too early to start it."""
        if self.decorated.status is not RUNNING and self._last is not None:
            left = self.left(self.duration, self._last)
            if left:
                self.feedback_message = f"cools down for {readable(round(left, 1), 's')} more"
                self.reset_child(self.feedback_message, seen)
                return FAILURE
        self.feedback_message = ""
        try:
            return tick(self.decorated, seen)
        finally:  # if it raises, too, it ran now
            self._last = self._clock.now()

    def terminate(self, new_status: Status) -> None:
        """Count from a halt."""
        if new_status is INVALID:
            self._last = self._clock.now()


class MinDuration(Timed):
    """Run the child, and go on RUNNING until some time is over; then give the child's result.

    The time counts from the start. A child that ended earlier is not ticked again.
    """

    duration: float = param(minimum=0, unit="s", doc="How long it runs at least.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, and RUNNING until the time is over."""
        return below.child | {RUNNING}

    @classmethod
    def results_at_once(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return nothing: it takes its time."""
        return NOTHING

    def initialise(self) -> None:
        """Start to measure."""
        self._started = self._clock.now()
        self._result: Status | None = None

    def advance(self, seen: Seen) -> Status:
        """Tick the child until it ends; give its result once the time is over."""
        if self._result is None:
            status = tick(self.decorated, seen)
            if status is RUNNING:
                return RUNNING
            self._result = status
        left = self.left(self.duration, self._started)
        what = self._result.name.lower()
        self.feedback_message = f"{what}, in {readable(round(left, 1), 's')}" if left else ""
        return RUNNING if left else self._result

    def tip(self) -> Behaviour | None:
        """Return itself while its child has ended and it goes on, else the deepest node below."""
        return self if self.status is RUNNING and self._result is not None else super().tip()
