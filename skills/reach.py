"""Bring a hand to something seen."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from humanoid_bt import Improving, Lasting, PerceptName, Side, Skill, Status, Steady, of_gaze, of_hand, param, result


class Reach(Skill):
    """Stand and bring a palm to the target, balanced, and keep it there for a moment.

    Waits for a steady base before it moves a hand. Fails if the target was never seen, or if the palm comes no
    nearer: it does not walk. Then it says which own link is in the way, if one is.
    """

    resources = ("left_hand", "right_hand", "gaze")
    bounded = True  # by its patience

    target: PerceptName = param(doc="Percept to reach for.")
    hand: Literal["left", "right", "nearest"] = param("nearest", doc="Which hand.")
    tolerance: float = param(0.015, unit="m", above=0, doc="Reached when the palm is this close.")
    hold: float = param(0.3, unit="s", minimum=0, doc="How long it must stay there.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when the palm comes no nearer for this long.")
    smoothing: float = param(0.4, unit="s", minimum=0, doc="Low-pass time of the target's position.")
    look: bool = param(True, doc="Look at the target, too.")

    hand_error: float = result(unit="m", doc="From the palm to the target.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand unless the nearest is to be chosen, and the gaze if it is to look."""
        return of_hand(of_gaze(cls.resources, values["look"]), values["hand"])

    def initialise(self) -> None:
        """Choose nothing yet: the hand is chosen once the robot stands."""
        self._hand: Side | None = None
        self._place = Steady(self.smoothing)
        self._held = Lasting(self.hold)
        self._error = Improving(self.patience, step=0.005)

    def update(self) -> Status:
        """Wait for a steady base, then move the palm to the target."""
        track = self.robot.track(self.target)
        if track is None:
            return self.fail(self.robot.why_unseen(self.target))
        if self.look:
            self.robot.look_at(track.position_world)
        if self._hand is None:
            if not self.robot.state.base_settled:
                return self.running("waiting for a steady base")
            self._hand = self._choose(track.bearing)
            if self._hand not in self.robot.state.hands:
                return self.fail(f"the robot has no {self._hand} hand")
        aim = self._place.update(track.position_world, track.stamp)
        self.robot.move_hand(self._hand, aim)

        now = self.robot.clock.now()
        self.hand_error = error = float(np.linalg.norm(self.robot.state.hands[self._hand] - aim))
        there = error <= self.tolerance
        if self._held.update(there, now):
            return self.succeed(f"{self._hand} hand {error * 100:.1f} cm from {self.target}")
        if there:
            self._error.restart()
        elif not self._error.update(error, now):
            return self.fail(self.robot.why_no_nearer(self._hand, self._error.best))
        return self.running(f"{self._hand} hand {error * 100:.0f} cm away")

    def _choose(self, bearing: float) -> Side:
        if self.hand != "nearest":
            return self.hand
        return "left" if bearing > 0 else "right"
