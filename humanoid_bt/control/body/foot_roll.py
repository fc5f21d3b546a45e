"""How a foot rolls over the ground: it leaves by its toe, and lands by its heel, as a person's does."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.planar import seen_from, wrap
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.config import GaitConfig, SoleConfig

_TOE_OFF, _HEEL_FIRST, _FLAT = 0.30, 0.80, 1.0  # shares of the swing at which it is pitched most, and not any more
_AS_PLANNED, _ASTRAY = 0.03, 0.10  # m from the planned foothold up to which it lands by its heel, and from which flat
_MISSED, _HURRY = 0.03, 0.3  # m that no foothold takes out, share by which it is quicker: from either on it stays flat
_FADE_TIME = 0.02  # s, low-pass of both: they jump


class FootRoll:
    """The pitch of one swinging foot.

    It is the whole of ``toe_off`` and ``heel_strike`` in a full stride, and less in a shorter one; a foot that goes
    back or aside, or is stopped, stays flat.

    Args:
        gait, sole: the robot's numbers.
        dt: control period [s].
        start, foothold: planned poses of the sole, shape (3,).

    Attributes:
        stride: how much of the longest step straight ahead it is, in [0, 1]; less if it turns or is disturbed.
    """

    def __init__(self, gait: GaitConfig, sole: SoleConfig, dt: float, start: Array, foothold: Array) -> None:
        self._gait, self._half_length = gait, sole.half_length
        self._fade = min(1.0, dt / _FADE_TIME)
        long = min(max(seen_from(start, foothold).item(0) / (2 * gait.step_forward), 0.0), 1.0)
        straight = max(0.0, 1.0 - abs(wrap(float(foothold[2] - start[2]))) / gait.step_turn)
        self._planned = self.stride = long * straight

    def footing(self, share: float, yaw: float, *, moved: float, missed: float, rate: float, stops: bool) -> Array:
        """Go on for one control period; return by how much the sole's centre is higher, and its tilt.

        The lowest edge of the sole stays where the centre of a flat one would be.

        Args:
            share: of the swing that is over.
            yaw: of the sole [rad].
            moved: how far the foothold is from where it was planned [m].
            missed: how far the DCM will be from where it should be when the foot lands [m].
            rate: how fast the swing runs; 1: as planned.
            stops: whether the robot is being stopped.

        Returns:
            The height [m], and the tilt about the world's x and y [rad], shape (3,).
        """
        calm = 0.0 if stops else max(0.0, 1.0 - max(missed / _MISSED, (rate - 1.0) / _HURRY))
        self.stride += self._fade * (calm * self._planned - self.stride)
        as_planned = 1.0 - min(max((moved - _AS_PLANNED) / (_ASTRAY - _AS_PLANNED), 0.0), 1.0)
        pitch = self.stride * _pitch(share, self._gait.toe_off, as_planned * self._gait.heel_strike)
        return np.array([self._half_length * math.sin(abs(pitch)), -pitch * math.sin(yaw), pitch * math.cos(yaw)])


def _pitch(share: float, toe_off: float, heel_strike: float) -> float:
    """Return the pitch in a full stride [rad], positive with the heel up."""
    if share < _TOE_OFF:
        return toe_off * _eased(share / _TOE_OFF)
    if share < _HEEL_FIRST:
        between = _eased((share - _TOE_OFF) / (_HEEL_FIRST - _TOE_OFF))
        return toe_off - between * (toe_off + heel_strike)
    return -heel_strike * (1.0 - _eased(min(1.0, (share - _HEEL_FIRST) / (_FLAT - _HEEL_FIRST))))


def _eased(share: float) -> float:
    """Return a share that begins and ends at rest."""
    return share * share * (3.0 - 2.0 * share)
