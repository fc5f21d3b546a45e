"""Point at something."""

import math
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

_STRETCHED = 0.9  # of the arm's length: a bit less than all, or it could not follow a target
_NEAREST = 0.5  # of it: for what is nearer, the arm would have to fold up
_CLEAR = 0.1  # m at least between the palm and the side of what it points at
_THERE = 0.05  # m from its place at which the palm counts as there: only where it points is judged closely


class PointAt(Skill):
    """Stretch an arm toward the target, its fingers along the line from the shoulder, and keep it so for a moment.

    Waits for a steady base before it moves a hand, half a minute at most, follows a target that moves, and stays clear
    of the side of a solid one. Fails if the target was never seen, is gone or too near, or if the hand does not come to
    point at it: it does not turn or walk. Then it says what keeps it. Fails, too, if it has pointed at it and does not
    do so for long enough, within five times the hold and the patience.
    """

    resources = ("left_hand", "right_hand", "gaze")
    bounded = True  # by its patience and its hold
    either_hand = True

    target: PerceptName = param(doc="Percept to point at.")
    hand: Literal["left", "right", "nearest"] = param("nearest", doc="Which hand.")
    tolerance: float = param(0.05, unit="rad", above=0, doc="Points at it when this close.")
    hold: float = param(1.0, unit="s", minimum=0, doc="How long to point at it.")
    patience: float = param(2.0, unit="s", above=0, doc="Fails when it comes no nearer for this long.")
    smoothing: float = param(0.4, unit="s", minimum=0, doc="Low-pass time of the target's position.")
    speed: float | None = param(None, unit="m/s", minimum=0.005, doc="At most this fast; default: as the robot can.")
    look: bool = param(True, doc="Look at the target, too.")

    angle_error: float = result(unit="rad", doc="From the fingers to the line from the palm to the target.")

    @classmethod
    def resources_for(cls, values: Mapping[str, Any]) -> tuple[str, ...]:
        """Return one hand unless the nearest is to be chosen, and the gaze if it is to look."""
        return of_hand(of_gaze(cls.resources, values["look"]), values["hand"])

    def initialise(self) -> None:
        """Choose nothing yet: the hand is chosen once the robot stands."""
        self._hand: Side | None = None
        self._place = Steady(self.smoothing)
        self._held = Lasting(self.hold, self.patience)
        self._error = Improving(self.patience, step=0.005)
        self._angle = Improving(self.patience, step=0.01)

    def update(self) -> Status:
        """Wait for a steady base, then stretch the arm toward the target."""
        track = self.robot.track(self.target)
        if track is None or track.gone:
            return self.fail(self.robot.why_unseen(self.target))
        if self.look:
            self.robot.look_at(track.position_world)
        if self._hand is None:
            if not self.robot.state.base_settled:
                return self.await_rest("waiting for a steady base")
            hand = self._choose(track.bearing)
            if hand not in self.robot.state.hands:
                return self.fail(f"the robot has no {hand} hand")
            self._hand = hand
            self._shoulder = self._from_stance(self.robot.pose(f"{hand}_shoulder").position)
        target = self._place.update(track.position_world, track.stamp)
        shoulder = self._in_world(self._shoulder)
        ahead, length = _towards(target, shoulder), self.robot.arm_length(self._hand)
        distance = math.dist(target, shoulder) - _half(track, ahead)
        if distance - _CLEAR < _NEAREST * length:
            away = f"{max(0.0, distance) * 100:.0f} cm from the shoulder"
            return self.fail(f"{self.target} is too near to point at: {away}")
        return self._point(self._hand, shoulder + min(_STRETCHED * length, distance - _CLEAR) * ahead, target)

    def _point(self, hand: Side, aim: np.ndarray, target: np.ndarray) -> Status:
        self.robot.move_hand(hand, aim, direction=_towards(target, aim), speed=self.speed)
        now, state = self.robot.clock.now(), self.robot.state
        error = float(np.linalg.norm(state.hands[hand] - aim))
        palm = self.robot.pose(f"{hand}_palm")
        cosine = float(palm.rotation[:, 0] @ _towards(target, palm.position))
        self.angle_error = angle = math.acos(max(-1.0, min(1.0, cosine)))
        there = error < _THERE and angle < self.tolerance
        if self._held.update(there, now):
            return self.succeed(f"{hand} hand points at {self.target}, {math.degrees(angle):.1f} deg off")
        if self._held.hopeless:
            return self.fail(f"{hand} hand does not keep pointing at {self.target} for {self.hold:g} s")
        if there:
            self._error.arrived(error)
            self._angle.arrived(angle)
            return self.running("pointing")
        nearer, turns = self._error.update(error, now), self._angle.update(angle, now)
        if self.robot.touched(hand) or (not nearer and not turns):
            if error < _THERE:
                return self.fail(self.robot.why_not_turned(hand, self._angle.best))
            return self.fail(self.robot.why_no_nearer(hand, self._error.best))
        return self.running(f"{hand} hand points {math.degrees(angle):.0f} deg beside it")

    def _choose(self, bearing: float) -> Side:
        return self.hand if self.hand != "nearest" else self.robot.nearest_hand(bearing)

    def _from_stance(self, place: np.ndarray) -> np.ndarray:
        """Return a place, shape (3,), as seen from where the robot stands: a body that leans does not move it."""
        x, y, heading = self.robot.state.stance
        return _turned(place - np.array([x, y, 0.0]), -heading)

    def _in_world(self, place: np.ndarray) -> np.ndarray:
        x, y, heading = self.robot.state.stance
        return _turned(place, heading) + np.array([x, y, 0.0])


def _towards(target: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the direction from a place to a target, shape (3,) each."""
    way: np.ndarray = target - place
    return way / max(float(np.linalg.norm(way)), 1e-9)


def _half(track: Track, way: np.ndarray) -> float:
    """Return how far a thing reaches from its middle along a way, a unit vector, shape (3,): 0 if it is not solid."""
    if track.size is None:
        return 0.0
    along = np.abs(_turned(way, -track.heading_world))
    return float(np.min(track.size / 2 / np.maximum(along, 1e-9)))


def _turned(place: np.ndarray, angle: float) -> np.ndarray:
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ place
