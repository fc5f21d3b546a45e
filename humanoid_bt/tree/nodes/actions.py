"""Built-in leaves that do something without commanding a resource."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from py_trees.common import Status

from humanoid_bt.core.messages import Level, Mode
from humanoid_bt.core.params import param
from humanoid_bt.core.units import readable
from humanoid_bt.tree.expressions.expression import Truth
from humanoid_bt.tree.expressions.linking import Unseen
from humanoid_bt.tree.expressions.template import Template
from humanoid_bt.tree.nodes.decorators import TIME_TOLERANCE
from humanoid_bt.tree.nodes.leaf import Leaf
from humanoid_bt.tree.results import SUCCEEDS, Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS, asked_again


class Success(Leaf):
    """Succeed at once."""

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return SUCCESS."""
        return frozenset({SUCCESS})

    def update(self) -> Status:
        """Succeed."""
        return SUCCESS


class Failure(Leaf):
    """Fail at once."""

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return FAILURE."""
        return frozenset({FAILURE})

    def update(self) -> Status:
        """Fail."""
        return FAILURE


class Running(Leaf):
    """Run for ever, and do nothing."""

    ends: ClassVar[bool] = False
    """Whether it can succeed or fail, as of skills."""

    def update(self) -> Status:
        """Go on."""
        return RUNNING


class Wait(Leaf):
    """Run for some time, then succeed."""

    main: ClassVar[str] = "duration"

    duration: float = param(minimum=0, unit="s", doc="How long.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return RUNNING and SUCCESS: it never fails."""
        return frozenset({RUNNING, SUCCESS})

    def initialise(self) -> None:
        """Start to measure."""
        self._started = self.robot.clock.now()

    def update(self) -> Status:
        """Succeed when the time is over."""
        left = self.duration - (self.robot.clock.now() - self._started)
        if left <= TIME_TOLERANCE:
            self.feedback_message = f"waited {readable(self.duration, 's')}"
            return SUCCESS
        self.feedback_message = f"{readable(round(left, 1), 's')} left"
        return RUNNING


class WaitUntil(Leaf):
    """Run until an expression is true, then succeed."""

    main: ClassVar[str] = "expression"
    bounded: ClassVar[bool] = False
    """Whether it ends by itself in bounded time, as of skills."""

    expression: Truth = param(doc="What must become true.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return RUNNING and SUCCESS: it never fails."""
        return frozenset({RUNNING, SUCCESS})

    @classmethod
    def results_at_once(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return SUCCESS: it may be true already."""
        return SUCCEEDS

    def initialise(self) -> None:
        """Begin anew: nothing held."""
        self.expression.forget()

    def update(self) -> Status:
        """Evaluate the expression; a percept that was never seen makes it false."""
        try:
            reached = self.expression.evaluate(self.robot)
        except Unseen as unseen:
            self.feedback_message = str(unseen)
            return RUNNING
        self.feedback_message = self.expression.explain()
        return SUCCESS if reached else RUNNING


class Log(Leaf):
    """Tell people something, as an event of the run, and succeed; it is recorded.

    In the text stand expressions in braces: `{distance(target)}` gives `0.82 m`. A percept that was never seen gives
    `(never seen)`, a key without a value `(not set)`; `{{` and `}}` are braces. A percept in it needs no watchdog, for
    nothing is decided by it.

    Told once for each start: where a node above that is RUNNING asks this one again in every tick, as a reactive
    composite and a guard's condition do, it succeeds and is silent.
    """

    main: ClassVar[str] = "text"
    path: str  # given by what builds the tree

    text: Template = param(doc="What to tell.")
    level: Level = param("info", doc="How much it matters.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return SUCCESS."""
        return SUCCEEDS

    def update(self) -> Status:
        """Tell it, unless it is only checked again."""
        if self.status is INVALID or not asked_again(self):
            self.feedback_message = self.text.fill(self.robot)
            self.robot.log(self.path, self.level, self.feedback_message)
        return SUCCESS


class RaiseEmergencyStop(Leaf):
    """Raise the emergency stop, with this node as its source.

    It is raised at once, whatever becomes of the rest of the tick. The node runs until the robot was stopped and then
    reset, and succeeds; below an `emergency_stop` it is halted before.
    """

    path: str  # given by what builds the tree

    reason: str = param(doc="Why; told to people, and recorded.")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], _below: Below) -> Results:
        """Return RUNNING and SUCCESS: it never fails."""
        return frozenset({RUNNING, SUCCESS})

    def update(self) -> Status:
        """Raise it, then wait until the robot was stopped and reset."""
        if self.status is not RUNNING:
            self._stopped = False
            self.robot.raise_estop(self.path, self.reason)
        self.feedback_message = f"raised the emergency stop: {self.reason}"
        latched = self.robot.state.mode in (Mode.EMERGENCY_STOP, Mode.DAMP)
        if self._stopped and not latched:
            self.feedback_message = "the emergency stop was reset"
            return SUCCESS
        self._stopped = latched
        return RUNNING

    def stop(self, new_status: Status) -> None:
        """Take the status; what was raised stays raised."""
        self.status = new_status
