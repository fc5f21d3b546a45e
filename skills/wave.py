"""Wave a hand."""

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from humanoid_bt import Improving, PerceptName, Side, Skill, Status, of_hand, param, result

_AHEAD, _ASIDE = 0.5, 0.8  # shares of the robot's reach; the raised palm is beside the head, the elbow bent


class Wave(Skill):
    """Raise a hand beside the head and wave it from side to side, balanced.

    Waits for a steady base before it moves the hand, half a minute at most. A wave counts once the palm has been on
    both sides. Fails if the palm does not get there.
    """

    resources = ("left_hand", "right_hand")
    bounded = True  # by its patience
    either_hand = True

    target: PerceptName | None = param(None, doc="Percept on whose side the nearest hand is; default: the right one.")
    hand: Literal["left", "right", "nearest"] = param("nearest", doc="Which hand.")
    times: int = param(3, minimum=1, doc="How often.")
    width: float = param(0.16, unit="m", above=0, maximum=0.3, doc="How far from side to side.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when the palm comes no nearer for this long.")

    waved: int = result(doc="How often it waved.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand unless the nearest is to be chosen."""
        return of_hand(cls.resources, values["hand"])

    def initialise(self) -> None:
        """Choose nothing yet: the hand is chosen once the robot stands."""
        self._hand: Side | None = None
        self._strokes = -1  # the first is the way up
        self._error = Improving(self.patience, step=0.005)

    def update(self) -> Status:
        """Move the palm to one side, then to the other."""
        state = self.robot.state
        if self._hand is None:
            if not state.base_settled:
                return self.await_rest("waiting for a steady base")
            self._hand = self._choose()
            if self._hand not in state.hands:
                return self.fail(f"the robot has no {self._hand} hand")
            self._height = float(state.gaze_position[2])
        aim = self._aim(self._hand)
        self.robot.move_hand(self._hand, aim)

        error = float(np.linalg.norm(state.hands[self._hand] - aim))
        if error < self.width / 4:
            self._strokes += 1
            self._error.restart()
        elif self.robot.touched(self._hand) or not self._error.update(error, self.robot.clock.now()):
            return self.fail(self.robot.why_no_nearer(self._hand, self._error.best))
        self.waved = max(self._strokes, 0) // 2
        if self.waved >= self.times:
            return self.succeed(f"waved the {self._hand} hand {_times(self.waved)}")
        if self._strokes < 0:
            return self.running(f"raising the {self._hand} hand")
        return self.running(f"waved {self.waved} of {_times(self.times)}")

    def _choose(self) -> Side:
        if self.hand != "nearest":
            return self.hand
        track = self.robot.track(self.target) if self.target else None
        return self.robot.nearest_hand(track.bearing if track else 0.0)

    def _aim(self, hand: Side) -> np.ndarray:
        """Return the end of this stroke, shape (3,), world frame [m]: the outer one first."""
        x, y, heading = self.robot.state.stance
        reach, outward = self.robot.config.reach_distance, 1 if hand == "left" else -1
        swing = self.width / 2 if self._strokes % 2 else -self.width / 2
        ahead, left = _AHEAD * reach, outward * (_ASIDE * reach + swing)
        cos, sin = math.cos(heading), math.sin(heading)
        return np.array([x + cos * ahead - sin * left, y + sin * ahead + cos * left, self._height])


def _times(number: int) -> str:
    return f"{number} time{'s' if number > 1 else ''}"
