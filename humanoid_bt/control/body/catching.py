"""When a standing robot has to step to stay on its feet, and with which foot.

It has to once the DCM is where no pressure under the feet can stop it. The foot is the one with which a quick step
lands nearest to where one more quick step can stop the DCM (Koolen, de Boer, Rebula, Goswami, Pratt,
"Capturability-based analysis and control of legged locomotion", IJRR 31(9), 2012).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from humanoid_bt.control.body.footsteps import OTHER, SIGN
from humanoid_bt.control.body.planar import seen_from
from humanoid_bt.control.body.support import beyond
from humanoid_bt.control.body.swing import REACH_FORWARD
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig

_BEYOND = 0.002  # m from where the feet can bear pressure
_AS_GOOD = 0.02  # m that one foot may miss by more than the other one


@dataclass(frozen=True, slots=True)
class _Candidate:
    side: Side
    miss: float  # m
    load: float  # share of the weight on this foot


class Catching:
    """Decides on steps that catch a standing robot.

    Args:
        gait, sole: the robot's numbers.
    """

    def __init__(self, gait: GaitConfig, sole: SoleConfig) -> None:
        self._gait = gait
        self._half = np.array(sole.bears)

    def step(
        self, dcm: Array, soles: Mapping[Side, Array], foot_force: Mapping[Side, float], omega: float
    ) -> tuple[Side, float] | None:
        """Return the foot that has to step and the time for the weight to leave it [s]; None if none has to.

        Args:
            dcm: measured, shape (2,), world frame [m].
            soles: measured poses, shape (3,), world frame.
            foot_force: measured normal forces [N].
            omega: [1/s].
        """
        if self.holds(dcm, soles):
            return None
        left, right = (self._candidate(side, dcm, soles, foot_force, omega) for side in SIDES)
        if abs(left.miss - right.miss) > _AS_GOOD:
            best = min(left, right, key=lambda one: one.miss)
        else:
            best = min(left, right, key=lambda one: one.load)
        return best.side, best.load * self._gait.quick_shift

    def holds(self, dcm: Array, soles: Mapping[Side, Array]) -> bool:
        """Return whether feet that both stand can stop the DCM; arguments as in :meth:`step`."""
        return beyond(dcm, soles, self._half) < _BEYOND

    def _candidate(
        self, side: Side, dcm: Array, soles: Mapping[Side, Array], foot_force: Mapping[Side, float], omega: float
    ) -> _Candidate:
        support = OTHER[side]
        load = max(foot_force[side], 0.0)
        load /= max(load + max(foot_force[support], 0.0), 1.0)
        return _Candidate(side, self._miss(side, load, dcm, soles[support], omega), load)

    def _miss(self, side: Side, load: float, dcm: Array, support: Array, omega: float) -> float:
        """Return how far from where another step stops the DCM it is when a quick step with this foot lands [m]."""
        gait, sign = self._gait, SIGN[side]
        x, y = seen_from(support, dcm).tolist()
        growth = math.exp(omega * (load * gait.quick_shift + gait.quickest_step))
        again = math.exp(-omega * gait.quickest_step)
        half_x, half_y = self._half.tolist()
        at_x, at_y = min(max(x, -half_x), half_x), min(max(sign * y, -half_y), half_y)
        x, y = at_x + (x - at_x) * growth, at_y + (sign * y - at_y) * growth
        back, ahead = (reach * (1 + again) for reach in REACH_FORWARD)
        near, far = gait.separation_min - gait.separation_max * again, gait.separation_max + half_y
        return math.hypot(max(back - x, 0.0, x - ahead), max(near - y, 0.0, y - far))
