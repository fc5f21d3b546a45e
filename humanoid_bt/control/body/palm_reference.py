"""The reference of one palm: its place and how it is turned, in the world or relative to the other palm."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from humanoid_bt.control.body.references import HandReference
from humanoid_bt.core.geometry import (
    clamp,
    quaternion,
    rotation_matrix,
    turn_between,
    turn_of_axis,
    turned,
)
from humanoid_bt.core.messages import Array, HandTarget, Pointing
from humanoid_bt.core.palm import axis_of
from humanoid_bt.robot.config import WholeBodyConfig

Frame = tuple[Array, Array]
"""A palm: its place, shape (3,), and its frame as a rotation matrix, shape (3, 3); world frame."""

_NOWHERE = np.zeros(3)  # the stance of what is held relative to a palm: it moves with nothing else
_CORRECT_WITHIN = 0.1  # rad from the target at which the measured error is integrated
_CORRECT_MAX = 0.1  # rad
_UPRIGHT = np.array([1.0, 0.0, 0.0, 0.0])


class PalmReference:
    """The reference of one palm.

    The place is that of :class:`HandReference`, which is all there is if nothing else is asked for. How the palm is
    turned follows its target by the shortest way at limited speed, never far ahead of the planned palm. What is
    relative to the other palm is followed in that one's frame.

    Args:
        weights: the robot's numbers.
        dt: control period [s].
    """

    def __init__(self, weights: WholeBodyConfig, dt: float) -> None:
        self._weights, self._dt = weights, dt
        self._place = HandReference(weights, dt)
        self._turn = TurnReference(weights.hand_turn_lead, weights.hand_integral * dt)
        self._turns = False
        self.relative = False

    def update(
        self,
        target: HandTarget | None,
        hold: bool,
        measured: Array,
        planned: Array,
        *,
        stance: Array,
        walks: bool,
        frames: Callable[[], tuple[Array, Array]],
    ) -> tuple[Array, HandTarget | None] | None:
        """Return where to bring the palm, world frame, and its goal if that is more; None when it is free.

        Args:
            target: in the world; None to release the hand.
            hold: stay, as seen from the stance, whatever the target.
            measured, planned: places of the palm, of the robot and of the inverse kinematics, shape (3,) [m].
            stance: pose of the middle between the feet, world frame, shape (3,).
            walks: whether the stance moves.
            frames: answers with the palm's frame, measured and planned: rotation matrices, shape (3, 3).
        """
        if not hold:
            self._begin(relative=False)
        place, speed, presses = (target.position, target.speed, bool(target.press)) if target else (None, None, False)
        position = self._place.update(
            place, hold, measured, planned, stance=stance, walks=walks, speed=speed, corrects=not presses
        )
        orientation = self._orientation(target, hold, position is None, frames, float(stance[2]))
        if position is None:
            return None
        return position, None if orientation is None else HandTarget(position, orientation, relative=False)

    def follow(
        self, target: HandTarget | None, hold: bool, measured: Frame, planned: Frame, leader: tuple[Frame, Frame]
    ) -> HandTarget | None:
        """Return the goal of a palm that is held relative to the other one, in that one's frame.

        Args:
            target: as seen from the other palm; None while it is held.
            hold: stay, as seen from the other palm, whatever the target.
            measured, planned: the palm, of the robot and of the inverse kinematics.
            leader: the other one, measured and planned.
        """
        if not hold:
            self._begin(relative=True)
        place, speed = (target.position, target.speed) if target else (None, None)
        seen = [_seen_from(one, other) for one, other in zip(leader, (measured, planned), strict=True)]
        position = self._place.update(place, hold, *seen, stance=_NOWHERE, speed=speed)
        frames = tuple(one[1].T @ other[1] for one, other in zip(leader, (measured, planned), strict=True))
        orientation = self._orientation(target, hold, position is None, lambda: (frames[0], frames[1]), 0.0)
        return None if position is None else HandTarget(position, orientation, relative=True)

    @property
    def free(self) -> bool:
        """Whether nothing holds the palm."""
        return self._place.free and not self._turns and not self.relative

    def release(self) -> None:
        """Let the palm go."""
        self._place = HandReference(self._weights, self._dt)
        self._turn.release()
        self._turns = self.relative = False

    def _begin(self, *, relative: bool) -> None:
        """Begin anew, from where the palm is, when what it is relative to is another than before."""
        if relative != self.relative:
            self.release()
            self.relative = relative

    def _orientation(
        self,
        target: HandTarget | None,
        hold: bool,
        free: bool,
        frames: Callable[[], tuple[Array, Array]],
        heading: float,
    ) -> Array | Pointing | None:
        wanted = target.orientation if target else None
        if free or (wanted is None and not hold):
            if self._turns:
                self._turn.release()
                self._turns = False
            return None
        if not hold:
            self._turns = True
        if not self._turns:
            return None
        weights, speed = self._weights, target.speed if target else None
        share = 1.0 if speed is None else min(1.0, speed / weights.hand_speed)
        step = share * weights.hand_turn_speed * self._dt
        return self._turn.update(None if hold else wanted, *frames(), heading=heading, step=step)


class TurnReference:
    """The reference of how a palm is turned: a whole orientation, or the direction of one axis.

    Near its target it corrects the measured error, as the reference of a place does.

    Args:
        lead: farthest it is ahead of the planned palm [rad].
        gain: share of the measured error that is corrected in a control period.
    """

    def __init__(self, lead: float, gain: float) -> None:
        self._lead, self._gain = lead, gain
        self.release()

    def release(self) -> None:
        """Begin from the planned palm the next time."""
        self._heading = 0.0  # of the stance, to which it belongs
        self._now: Array | Pointing | None = None
        self._sent: Array | Pointing | None = None  # what was returned last
        self._correction: Array = np.zeros(3)  # rotation vector

    def update(
        self, target: Array | Pointing | None, measured: Array, planned: Array, *, heading: float, step: float
    ) -> Array | Pointing:
        """Return how the inverse kinematics shall turn the palm.

        Args:
            target: wxyz, shape (4,), or a direction; None to stay as seen from the stance.
            measured, planned: frame of the palm, of the robot and of the inverse kinematics, shape (3, 3).
            heading: of the stance [rad].
            step: how far it may turn in this control period [rad].
        """
        before, self._heading = self._heading, heading
        if _kind(self._now) != _kind(target) and target is not None:
            self._now, self._sent, self._correction = None, None, np.zeros(3)
        kind = target if self._now is None else self._now
        assert kind is not None  # it is held only after it was commanded
        start = _as(kind, planned)
        now, sent = start if self._now is None else self._now, start if self._sent is None else self._sent
        if target is None:
            turn = np.array([0.0, 0.0, heading - before])
            now, sent = _turned(now, turn), _turned(sent, turn)
            self._correction = rotation_matrix(turned(_UPRIGHT, turn)) @ self._correction
        else:
            now = _toward(now, target, step)
            if _way(now, target) < _CORRECT_WITHIN:
                error = _turn_between(_as(kind, measured), target)
                self._correction = clamp(self._correction + self._gain * error, -_CORRECT_MAX, _CORRECT_MAX)
        self._now = _toward(start, now, self._lead + _CORRECT_MAX)
        self._sent = _toward(sent, _turned(self._now, self._correction), step)
        return self._sent


def _kind(orientation: Array | Pointing | None) -> object:
    """Return what tells apart orientations of which one cannot go on as the other: an axis, or none."""
    return orientation.axis if isinstance(orientation, Pointing) else orientation is None


def _as(kind: Array | Pointing, frame: Array) -> Array | Pointing:
    """Return how a palm is turned, whose frame is given, in the form of another orientation."""
    return Pointing(axis_of(frame, kind.axis), kind.axis) if isinstance(kind, Pointing) else quaternion(frame)


def _turn_between(start: Array | Pointing, goal: Array | Pointing) -> Array:
    """Return the shortest rotation vector, shape (3,), from an orientation to another of the same form."""
    if isinstance(start, Pointing) and isinstance(goal, Pointing):
        return turn_of_axis(start.direction, goal.direction)
    assert not isinstance(start, Pointing) and not isinstance(goal, Pointing)
    return turn_between(start, goal)


def _way(start: Array | Pointing, goal: Array | Pointing) -> float:
    turn = _turn_between(start, goal)
    return math.sqrt(turn @ turn)


def _turned(orientation: Array | Pointing, turn: Array) -> Array | Pointing:
    """Return an orientation after it was turned by a rotation vector, shape (3,)."""
    if not turn.any():
        return orientation
    if isinstance(orientation, Pointing):
        direction = rotation_matrix(turned(_UPRIGHT, turn)) @ orientation.direction
        return Pointing(direction / math.sqrt(direction @ direction), orientation.axis)
    return turned(orientation, turn)


def _toward(start: Array | Pointing, goal: Array | Pointing, most: float) -> Array | Pointing:
    """Return an orientation turned toward another, the shortest way, by at most an angle [rad]."""
    turn = _turn_between(start, goal)
    angle = math.sqrt(turn @ turn)
    return goal if angle <= most else _turned(start, turn * (most / angle))


def _seen_from(leader: Frame, palm: Frame) -> Array:
    """Return the place of a palm as seen from another one, shape (3,)."""
    return np.asarray(leader[1].T @ (palm[0] - leader[0]))
