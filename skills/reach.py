"""Bring a hand to something seen."""

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from humanoid_bt.messages import Side
from humanoid_bt.params import param
from humanoid_bt.skill import PerceptName, Skill, Status

_MOVED = 0.04  # m; more than a percept's noise


class Reach(Skill):
    """Stand and bring a palm to the target, balanced, and keep it there for a moment.

    Waits for a steady base before it moves a hand. Fails if the target was never seen, or if the palm comes no
    nearer: it does not walk.
    """

    resources = ("left_hand", "right_hand", "gaze")
    bounded = True  # by its patience

    target: PerceptName = param(doc="Percept to reach for.")
    hand: Literal["left", "right", "nearest"] = param("nearest", doc="Which hand.")
    tolerance: float = param(0.015, unit="m", above=0, doc="Reached when the palm is this close.")
    hold: float = param(0.3, unit="s", minimum=0, doc="How long it must stay there.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when the palm comes no nearer for this long.")
    smoothing: float = param(0.4, unit="s", minimum=0, doc="Low-pass time of the target's position.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand unless the nearest is to be chosen."""
        return cls.resources if values["hand"] == "nearest" else (f"{values['hand']}_hand", "gaze")

    def initialise(self) -> None:
        """Choose nothing yet: the hand is chosen once the robot stands."""
        self._hand: Side | None = None
        self._aim: np.ndarray | None = None
        self._last_stamp = -math.inf
        self._reached_since: float | None = None
        self._nearest = math.inf
        self._nearest_at = 0.0

    def update(self) -> Status:
        """Wait for a steady base, then move the palm to the target."""
        track = self.robot.track(self.target)
        if track is None:
            return self.fail(f"{self.target} was never seen")
        self.robot.look_at(track.position_world)
        if self._hand is None:
            if not self.robot.state.base_settled:
                return self.running("waiting for a steady base")
            self._hand = self._choose(track.bearing)
            if self._hand not in self.robot.state.hands:
                return self.fail(f"the robot has no {self._hand} hand")
            self._nearest_at = self.robot.clock.now()
        aim = self._follow(track.position_world, track.stamp)
        self.robot.move_hand(self._hand, aim)

        now = self.robot.clock.now()
        error = float(np.linalg.norm(self.robot.state.hands[self._hand] - aim))
        if error > self.tolerance:
            self._reached_since = None
        elif self._reached_since is None:
            self._reached_since = now
        if self._reached_since is not None and now - self._reached_since >= self.hold:
            return self.succeed(f"{self._hand} hand {error * 100:.1f} cm from {self.target}")
        if error < self._nearest - 0.005:
            self._nearest, self._nearest_at = error, now
        elif self._reached_since is None and now - self._nearest_at > self.patience:
            return self.fail(f"{self._hand} hand comes no nearer than {self._nearest * 100:.0f} cm")
        return self.running(f"{self._hand} hand {error * 100:.0f} cm away")

    def _choose(self, bearing: float) -> Side:
        if self.hand != "nearest":
            return self.hand
        return "left" if bearing > 0 else "right"

    def _follow(self, position: np.ndarray, stamp: float) -> np.ndarray:
        """Low-pass the target's position, once per percept; follow at once what has really moved."""
        if self._aim is None or np.linalg.norm(position - self._aim) > _MOVED:
            self._aim = position.copy()
        elif stamp > self._last_stamp:
            elapsed = stamp - self._last_stamp
            self._aim = self._aim + (position - self._aim) * (elapsed / (elapsed + self.smoothing))
        self._last_stamp = max(self._last_stamp, stamp)
        return self._aim
