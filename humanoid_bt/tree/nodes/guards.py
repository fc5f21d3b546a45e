"""Decorators that keep the robot safe: they ask and explain; the supervisor below the tree enforces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.messages import Mode
from humanoid_bt.core.params import PerceptName, param
from humanoid_bt.core.units import readable_pair
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.nodes import other_libraries
from humanoid_bt.tree.nodes.decorators import TIME_TOLERANCE, Decorator
from humanoid_bt.tree.nodes.family import child_of
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.slots import Slot
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, Seen, halt, tick

_RUN = Mode.RUN  # reading a member from its class costs more than comparing it


class EmergencyStop(Decorator):
    """Hold while the robot is stopped: the child is halted, and starts afresh when the robot may move again.

    Skills that command the robot stand below one. In an emergency stop it waits for a person's reset, `humanoid-bt
    reset` or the key `r`; in a protective stop until its cause is gone. Until then the node runs, and so does the
    tree; whether the *run* waits too is its option `--on-estop`.
    """

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        other_libraries.refuse_parameters(self, values)
        super().__init__(name, child, **values)

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, and RUNNING: a stop can come at any time."""
        return below.child | {RUNNING}

    def setup(self, **kwargs: Any) -> None:
        """Take ``robot``."""
        self.robot: Robot = kwargs["robot"]

    def advance(self, seen: Seen) -> Status:
        """Tick the child if the robot may run."""
        state = self.robot.state
        if state.mode is _RUN:
            self.feedback_message = ""
            return tick(self.decorated, seen)
        what = {Mode.PROTECTIVE_STOP: "held", Mode.DAMP: "damped"}.get(state.mode, "emergency stop")
        source = f" (from {state.stop_source})" if state.stop_source else ""
        self.feedback_message = f"{what}: {state.stop_reason or 'no reason given'}{source}"
        if self.decorated.status is not INVALID:
            halt(self.decorated, self.feedback_message, seen)
        if state.mode is Mode.EMERGENCY_STOP:
            self.feedback_message += "; waiting for a reset"
        return RUNNING


class Watchdog(Decorator):
    """Run the child only while a percept is fresh; run ``on_stale`` instead, or fail, while it is not."""

    branches: ClassVar[dict[str, Slot]] = {"on_stale": Slot("What runs while the percept is stale; without it, fail.")}

    percept: PerceptName = param(doc="The percept to watch.")
    max_age: float = param(above=0, unit="s", doc="Older than this it is stale.")

    def __init__(self, name: str, child: Behaviour, on_stale: Behaviour | None = None, **values: Any) -> None:
        super().__init__(name, child, **values)
        self.on_stale = None if on_stale is None else child_of(type(self), name, on_stale, "on_stale")
        if on_stale is not None:
            self.children.append(on_stale)
            on_stale.parent = self

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the results of the child and of what runs while the percept is stale."""
        return below.child | below.branches.get("on_stale", {FAILURE})

    def setup(self, **kwargs: Any) -> None:
        """Take ``robot``."""
        self.robot: Robot = kwargs["robot"]

    def advance(self, seen: Seen) -> Status:
        """Tick the child or ``on_stale``, and halt the other."""
        track = self.robot.track(self.percept)
        if track is not None and track.age <= self.max_age + TIME_TOLERANCE:
            self.feedback_message = ""
            if self.on_stale is not None and self.on_stale.status is not INVALID:
                halt(self.on_stale, f"{self.percept!r} is fresh again", seen)
            return tick(self.decorated, seen)
        if track is None:
            self.feedback_message = self.robot.why_unseen(self.percept)
        else:
            age, limit = readable_pair(track.age, self.max_age, "s")
            self.feedback_message = f"{self.percept!r} is {age} old (limit {limit})"
        if self.decorated.status is not INVALID:
            halt(self.decorated, self.feedback_message, seen)
        return FAILURE if self.on_stale is None else tick(self.on_stale, seen)

    def tip(self) -> Behaviour | None:
        """Return the deepest node of the branch that was ticked last."""
        if self.on_stale is not None and self.on_stale.status is not INVALID:
            return self.on_stale.tip()
        return super().tip()
