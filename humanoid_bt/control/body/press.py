"""A palm that moves on until it touches something, and presses against it with a force."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.messages import Array

_SPEED = 0.1  # m/s at most, of the palm before and while it presses
_TOUCHES = 4.0  # N against the palm's way that count as touching
_RISE = 20.0  # N/s of the force that it presses with: the body has to lean against it meanwhile
_GAIN = 0.006  # m/s that it presses on for every newton that is missing
_ELSEWHERE = 0.05  # m from a target to another one for which it begins anew


class Press:
    """The reference of a palm that presses: admittance along the way to its target.

    Once it touches something it keeps to that way, until it is to press elsewhere.

    Args:
        dt: control period [s].
    """

    def __init__(self, dt: float) -> None:
        self._dt = dt
        self._point: Array | None = None
        self._target: Array = np.zeros(3)  # for which it has begun
        self._way: Array = np.zeros(3)
        self._touches = False
        self._asked = _TOUCHES  # with how much it is to press by now [N]

    def reset(self) -> None:
        """Begin anew the next time."""
        self._point = None

    def aim(self, target: Array, wanted: float, palm: Array, force: Array) -> Array:
        """Return where the palm's reference is to go, shape (3,), world frame [m].

        Args:
            target: where its way would end if nothing were there, shape (3,), world frame [m].
            wanted: force with which it is to press [N].
            palm: where it is planned to be, shape (3,), world frame [m].
            force: what pushes it, world frame, shape (3,) [N].
        """
        if self._point is None or math.dist(target, self._target) > _ELSEWHERE:
            self._point, self._target = palm, target.copy()
            self._touches, self._asked = False, _TOUCHES
        rest = target - self._point
        length = math.sqrt(rest @ rest)
        if not self._touches and length > 0.0:
            self._way = rest / length
        pressed = -float(force @ self._way)
        self._touches = self._touches or pressed > _TOUCHES
        speed = _SPEED
        if self._touches:
            self._asked = min(self._asked + _RISE * self._dt, wanted)
            speed = _GAIN * (self._asked - pressed)
        step = min(speed * self._dt, float(rest @ self._way))
        most = _SPEED * self._dt
        self._point = self._point + self._way * min(max(step, -most), most)
        return self._point
