"""Hold a hand out to somebody."""

from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from humanoid_bt import (
    Improving,
    Lasting,
    PerceptName,
    Side,
    Skill,
    Status,
    Steady,
    Track,
    of_gaze,
    of_hand,
    param,
    result,
)

_HEIGHT = 0.75  # of the eyes' height: the chest


class Offer(Skill):
    """Stand and hold a palm out toward the target, balanced, and keep it there for a time.

    The palm stays clear of the target, seen from above, and draws back from one that comes nearer, as quickly as the
    hand moves. Waits for a steady base before it moves a hand, half a minute at most. Fails if the target was never
    seen, is gone or too near, or if the palm does not get there: it does not walk or turn. Fails, too, if the palm was
    there and does not stay long enough, within five times the hold and the patience.
    """

    resources = ("left_hand", "right_hand", "gaze")
    bounded = True  # by its patience and its hold
    either_hand = True

    target: PerceptName = param(doc="Percept to hold the hand out to.")
    hand: Literal["left", "right", "nearest"] = param("nearest", doc="Which hand.")
    distance: float | None = param(
        None, unit="m", above=0, doc="Palm this far from the middle between the feet; default: the robot's reach."
    )
    height: float | None = param(
        None, unit="m", above=0, maximum=10, doc="Palm this far above the floor; default: the chest."
    )
    clearance: float = param(0.2, unit="m", above=0, doc="Least distance of the palm from the target, seen from above.")
    tolerance: float = param(0.03, unit="m", above=0, doc="There when the palm is this close.")
    hold: float = param(2.0, unit="s", minimum=0, doc="How long to hold it there.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when the palm comes no nearer for this long.")
    look: bool = param(True, doc="Look at the target, too.")

    hand_error: float = result(unit="m", doc="From the palm to where it is held out.")
    target_distance: float = result(unit="m", doc="From the middle between the feet to the target, seen from above.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand unless the nearest is to be chosen, and the gaze if it is to look."""
        return of_hand(of_gaze(cls.resources, values["look"]), values["hand"])

    def initialise(self) -> None:
        """Choose nothing yet: the hand is chosen once the robot stands."""
        self._hand: Side | None = None
        self._height = 0.0
        self._place = Steady(time=0.4)
        self._held = Lasting(self.hold, self.patience)
        self._error = Improving(self.patience, step=0.005)

    def update(self) -> Status:
        """Wait for a steady base, then hold the palm out."""
        track, state = self.robot.track(self.target), self.robot.state
        if track is None or track.gone:
            return self.fail(self.robot.why_unseen(self.target))
        self.target_distance = track.distance
        if self.look:
            self.robot.look_at(track.position_world)
        if self._hand is None:
            if not state.base_settled:
                return self.await_rest("waiting for a steady base")
            self._hand = self._choose(track.bearing)
            if self._hand not in state.hands:
                return self.fail(f"the robot has no {self._hand} hand")
            self._height = _HEIGHT * float(state.gaze_position[2]) if self.height is None else self.height
        aim = self._aim(track)
        if aim is None:
            nearest = self.robot.config.whole_body.hand_nearest
            if self.distance is not None and self.distance < nearest:
                return self.fail(f"{self.distance:.2f} m is too near to hold a palm out: it takes {nearest:.2f} m")
            return self.fail(f"{self.target} is too near: {track.distance:.2f} m")
        return self._hold_out(self._hand, aim)

    def _hold_out(self, hand: Side, aim: np.ndarray) -> Status:
        self.robot.move_hand(hand, aim)
        now = self.robot.clock.now()
        self.hand_error = error = float(np.linalg.norm(self.robot.state.hands[hand] - aim))
        there = error < self.tolerance
        if self._held.update(there, now):
            return self.succeed(f"held the {hand} hand out for {self.hold:g} s")
        if self._held.hopeless:
            return self.fail(f"{hand} hand does not stay where it is held out for {self.hold:g} s")
        if there:
            self._error.arrived(error)
        elif self.robot.touched(hand) or not self._error.update(error, now):
            return self.fail(self.robot.why_no_nearer(hand, self._error.best))
        return self.running("holding it out" if there else f"{hand} hand {error * 100:.0f} cm away")

    def _choose(self, bearing: float) -> Side:
        return self.hand if self.hand != "nearest" else self.robot.nearest_hand(bearing)

    def _aim(self, track: Track) -> np.ndarray | None:
        """Return where the palm belongs, shape (3,), world frame [m], None if no place is left for it."""
        config, middle = self.robot.config, self.robot.state.stance[:2]
        way = self._place.update(track.position_world, track.stamp)[:2] - middle
        length = float(np.linalg.norm(way))
        wanted = config.reach_distance if self.distance is None else self.distance
        out = min(wanted, min(length, track.distance) - self.clearance)
        if out < config.whole_body.hand_nearest:
            return None
        return np.array([*(middle + way * (out / length)), self._height])
