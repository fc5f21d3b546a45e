"""Take the arms back."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from humanoid_bt import SIDES, Lasting, Mode, Side, Skill, Status, of_hand, param, result, rotation_matrix


class Retract(Skill):
    """Leave the hands alone until they hang beside the body again.

    It commands nothing: it takes the hands, so that nobody else moves them, and sets no target. Control then takes
    the joints of a released hand back to the home posture, slowly. Succeeds once the palms have stopped moving. Fails
    if they do not come to rest; while the robot is stopped they stay where they are.
    """

    resources = ("left_hand", "right_hand")
    bounded = True  # by its patience

    hand: Literal["left", "right", "both"] = param("both", doc="Which hand.")
    speed: float = param(0.02, unit="m/s", above=0, doc="At rest when the palm moves more slowly than this.")
    hold: float = param(0.3, unit="s", above=0, doc="How long it must be at rest.")
    patience: float = param(6.0, unit="s", above=0, doc="Fails when it is not at rest after this long.")

    took: float = result(unit="s", doc="How long it took.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand unless it takes both."""
        return of_hand(cls.resources, values["hand"])

    def initialise(self) -> None:
        """Begin to watch."""
        self._since = self._last_time = self.robot.clock.now()
        self._last: dict[Side, np.ndarray] = {}
        self._rested = Lasting(self.hold)

    def update(self) -> Status:
        """Watch the palms."""
        state, now = self.robot.state, self.robot.clock.now()
        sides = [side for side in SIDES if self.hand in (side, "both")]
        missing = [side for side in sides if side not in state.hands]
        if missing:
            return self.fail(f"the robot has no {missing[0]} hand")
        self.took = now - self._since
        speed = self._speed(sides)
        free = state.mode is Mode.RUN and not any(f"{side}_hand" in state.targets for side in sides)
        if self._rested.update(free and speed < self.speed, now):
            return self.succeed("the hands are at rest" if self.hand == "both" else f"the {self.hand} hand is at rest")
        if now - self._since > self.patience:
            return self.fail(state.stop_reason or f"the hands do not come to rest: {speed:.2f} m/s")
        return self.running(state.stop_reason or ("going back" if free else "letting go"))

    def _speed(self, sides: list[Side]) -> float:
        """Return the speed of the faster palm, as seen from the body, since the last tick [m/s]."""
        state = self.robot.state
        turn = rotation_matrix(state.base_quaternion).T
        palms = {side: turn @ (state.hands[side] - state.base_position) for side in sides}
        elapsed = state.time - self._last_time
        ways = [float(np.linalg.norm(palms[side] - last)) for side, last in self._last.items()]
        self._last, self._last_time = palms, state.time
        return max(ways) / elapsed if ways and elapsed > 0 else np.inf
