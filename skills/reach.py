"""Bring a hand to something seen."""

import math
from collections.abc import Mapping
from typing import Any, Literal

import numpy as np

from humanoid_bt import (
    HandRoute,
    Improving,
    Lasting,
    PerceptName,
    Side,
    Skill,
    Status,
    Steady,
    of_gaze,
    of_hand,
    param,
    result,
)

_AHEAD = math.radians(20)  # bearing of what the other hand may get to, too


class Reach(Skill):
    """Stand and bring a palm to the target, balanced, and keep it there for a moment.

    With a direction it turns the hand, too: its fingers point there, or the palm faces there. Waits for a steady base,
    half a minute at most, before it moves a hand, which goes over what is solid and was seen, such as the table below a
    cup. Where the nearest hand comes no nearer to what is ahead, the other one tries. Fails if the target was never
    seen or is gone, or if the palm comes no nearer: it does not walk. Then it says which own link or which thing is in
    the way, if one is, or what touched the arm. Fails, too, if the palm was there and does not stay long enough, within
    five times the hold and the patience.
    """

    resources = ("left_hand", "right_hand", "gaze")
    bounded = True  # by its patience and its hold
    either_hand = True

    target: PerceptName = param(doc="Percept to reach for.")
    hand: Literal["left", "right", "nearest"] = param(
        "nearest", doc="Which hand; nearest: the other one, too, where that one does not get to what is ahead."
    )
    tolerance: float = param(0.015, unit="m", above=0, doc="Reached when the palm is this close.")
    hold: float = param(0.3, unit="s", minimum=0, doc="How long it must stay there.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when the palm comes no nearer for this long.")
    direction: tuple[float, float, float] | None = param(
        None, doc="Where to point an axis of the hand, as seen from the robot: ahead, left, up; default: anywhere."
    )
    axis: Literal["fingers", "facing"] = param("fingers", doc="Which axis: the fingers, or where the palm faces.")
    turn_tolerance: float = param(0.05, unit="rad", above=0, doc="Turned there when this close.")
    speed: float | None = param(None, unit="m/s", minimum=0.005, doc="At most this fast; default: as the robot can.")
    smoothing: float = param(0.4, unit="s", minimum=0, doc="Low-pass time of the target's position.")
    look: bool = param(True, doc="Look at the target, too.")

    hand_error: float = result(unit="m", doc="From the palm to the target.")
    turn_error: float = result(unit="rad", doc="From where the hand points to the direction, if one is given.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand unless the nearest is to be chosen, and the gaze if it is to look."""
        return of_hand(of_gaze(cls.resources, values["look"]), values["hand"])

    def initialise(self) -> None:
        """Choose nothing yet: the hand is chosen once the robot stands."""
        self._hand: Side | None = None
        self._short = ""  # why the hand that was chosen first did not get there
        self._place = Steady(self.smoothing)
        self._begin()

    def _begin(self) -> None:
        """Begin with a hand that has not moved."""
        self._held = Lasting(self.hold, self.patience)
        self._route = HandRoute(self.robot)
        self._error = Improving(self.patience, step=0.005)
        self._turn_error = Improving(self.patience, step=0.02)

    def update(self) -> Status:
        """Wait for a steady base, then move the palm to the target."""
        track = self.robot.track(self.target)
        if track is None or track.gone:
            return self.fail(self.robot.why_unseen(self.target))
        if self.look:
            self.robot.look_at(track.position_world)
        if self._hand is None:
            if not self.robot.state.base_settled:
                return self.await_rest("waiting for a steady base")
            self._hand = self._choose(track.bearing)
            if self._hand not in self.robot.state.hands:
                return self.fail(f"the robot has no {self._hand} hand")
        aim = self._place.update(track.position_world, track.stamp)
        if self.direction is not None and not any(self.direction):
            return self.fail("the direction is zero: it points nowhere")
        return self._bring(self._hand, aim, track.bearing)

    def _bring(self, hand: Side, aim: np.ndarray, bearing: float) -> Status:
        direction = self._direction()
        place = self._route.next(hand, aim, ignore=[self.target])
        self.robot.move_hand(hand, place, direction=direction, axis=self.axis, speed=self.speed)
        now, turn_error = self.robot.clock.now(), 0.0
        offset = self.robot.state.hands[hand] - aim
        self.hand_error = error = math.sqrt(offset @ offset)
        if direction is not None:
            axis = self.robot.pose(f"{hand}_palm").rotation[:, 0 if self.axis == "fingers" else 2]
            self.turn_error = turn_error = math.acos(max(-1.0, min(1.0, float(axis @ direction))))
        there, turned = error <= self.tolerance, turn_error <= self.turn_tolerance
        if self._held.update(there and turned, now):
            return self.succeed(f"{hand} hand {error * 100:.1f} cm from {self.target}")
        if self._held.hopeless:
            return self.fail(f"{hand} hand does not stay at {self.target} for {self.hold:g} s")
        if there and turned:
            self._error.arrived(error)
            self._turn_error.arrived(turn_error)
        elif self.robot.touched(hand) or not self._improves(error, turn_error, now):
            if there:
                why = self.robot.why_not_turned(hand, self._turn_error.best)
            else:
                why = self._route.why_no_nearer(hand, self._error.best)
            other: Side = "right" if hand == "left" else "left"
            if self._short or not self._may_try(other, hand, bearing):
                return self.fail("; ".join(filter(None, (self._short, why))))
            self._short, self._hand = why, other
            self._begin()
            return self.running(why)
        if there and not turned:
            return self.running(f"{hand} hand turned {math.degrees(turn_error):.0f} deg away")
        return self.running(f"{hand} hand {error * 100:.0f} cm away")

    def _may_try(self, other: Side, hand: Side, bearing: float) -> bool:
        if self.hand != "nearest" or abs(bearing) > _AHEAD or self._route.blocked or self.robot.touched(hand):
            return False
        return other in self.robot.state.hands

    def _improves(self, error: float, turn_error: float, now: float) -> bool:
        nearer, turns = self._error.update(error, now), self._turn_error.update(turn_error, now)
        return nearer or (turns and turn_error > self.turn_tolerance)

    def _direction(self) -> np.ndarray | None:
        """Return the direction as a unit vector, shape (3,), world frame."""
        if self.direction is None:
            return None
        x, y, z = np.array(self.direction) / np.abs(self.direction).max()
        heading = self.robot.state.stance[2]
        cos, sin = math.cos(heading), math.sin(heading)
        direction = np.array([cos * x - sin * y, sin * x + cos * y, z])
        return direction / np.linalg.norm(direction)

    def _choose(self, bearing: float) -> Side:
        return self.hand if self.hand != "nearest" else self.robot.nearest_hand(bearing)
