"""Stretch a hand toward something."""

import numpy as np

from humanoid_bt import Improving, Lasting, PerceptName, Side, Skill, Status, param, result

_CHEST = 0.8  # of the eyes' height


class StretchToward(Skill):
    """Stretch the hand on its side toward the target, and keep it there for a moment.

    Waits for a steady base before it moves a hand. Fails if the target was never seen, or if the palm does not get
    there.
    """

    resources = ("left_hand", "right_hand", "gaze")
    bounded = True  # by its patience

    target: PerceptName = param(doc="Percept to point at.")
    hold: float = param(1.0, unit="s", minimum=0, doc="How long to point at it.")
    tolerance: float = param(0.03, unit="m", above=0, doc="There when the palm is this close.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when the palm comes no nearer for this long.")

    hand_error: float = result(unit="m", doc="From the palm to where it belongs.")

    def initialise(self) -> None:
        """Choose no hand yet."""
        self._hand: Side | None = None
        self._held = Lasting(self.hold)
        self._error = Improving(self.patience, step=0.005)

    def update(self) -> Status:
        """Look at the target, and bring the palm between the chest and it."""
        track, state = self.robot.track(self.target), self.robot.state
        if track is None:
            return self.fail(self.robot.why_unseen(self.target))
        self.robot.look_at(track.position_world)
        if self._hand is None:
            if not state.base_settled:
                return self.await_rest("waiting for a steady base")
            self._hand = "left" if track.bearing > 0 else "right"
        chest = np.array([*state.stance[:2], _CHEST * state.gaze_position[2]])
        way = track.position_world - chest
        aim = chest + way * (self.robot.config.reach_distance / np.linalg.norm(way))
        self.robot.move_hand(self._hand, aim)

        now = self.robot.clock.now()
        self.hand_error = error = float(np.linalg.norm(state.hands[self._hand] - aim))
        there = error < self.tolerance
        if self._held.update(there, now):
            return self.succeed(f"pointed at {self.target} with the {self._hand} hand")
        if not there and not self._error.update(error, now):
            return self.fail(f"{self._hand} hand comes no nearer than {self._error.best * 100:.0f} cm")
        return self.running("pointing" if there else f"{self._hand} hand {error * 100:.0f} cm away")
