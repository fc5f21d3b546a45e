"""The plan of the divergent component of motion (DCM) over the next steps.

DCM: xi = c + c_dot / omega with omega = sqrt(g / z_c). Given where the zero-moment point (ZMP) shall be, the DCM that
ends at rest follows backward in time (Englsberger, Ott, Albu-Schaeffer, "Three-dimensional bipedal walking control
based on divergent component of motion", IEEE T-RO 31(2), 2015).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from humanoid_bt.control.body.body import Footstep
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.config import GaitConfig

_UNLOADED = 0.8  # of the way to the foot that is to swing: the other one stays on the ground
_REST = 0.5  # s of rest at the end of a plan, so that its tail is flat


@dataclass(frozen=True)
class DcmPlan:
    """A plan sampled every control period.

    Attributes:
        zmp: reference of the zero-moment point, shape (n, 2), world frame [m].
        dcm: reference of the divergent component of motion, shape (n, 2), world frame [m].
    """

    zmp: Array
    dcm: Array

    def __len__(self) -> int:
        return len(self.zmp)


def plan_dcm(zmp: Array, omega: float, dt: float) -> Array:
    """Return the DCM that belongs to a ZMP trajectory and comes to rest on its last point.

    xi_k = p_k + (xi_{k+1} - p_k) exp(-omega dt), from the end backward.

    Args:
        zmp: shape (n, 2) [m].
        omega: [1/s].
        dt: [s].
    """
    dcm = np.empty_like(zmp)
    _follow_back(dcm, zmp, math.exp(-omega * dt))
    return dcm


@compiled("void(f8[:, ::1], f8[:, ::1], f8)")
def _follow_back(dcm: Array, zmp: Array, decay: float) -> None:
    """Write a DCM, shape (n, 2): see :func:`plan_dcm`; ``decay`` is that of its way to the ZMP in a period."""
    x, y = zmp[-1, 0], zmp[-1, 1]
    for now in range(len(zmp) - 1, -1, -1):
        point_x, point_y = zmp[now, 0], zmp[now, 1]
        x, y = point_x + (x - point_x) * decay, point_y + (y - point_y) * decay
        dcm[now, 0], dcm[now, 1] = x, y


def plan_walk(
    gait: GaitConfig,
    omega: float,
    dt: float,
    *,
    zmp: Array,
    support: Array,
    shift: float,
    steps: Sequence[Footstep],
    begins: Array | None = None,
) -> DcmPlan:
    """Plan from a weight shift onto the support foot over the given footholds to rest.

    Args:
        gait: the robot's gait.
        omega: [1/s].
        dt: [s].
        zmp: where the ZMP is now, shape (2,) [m].
        support: pose of the foot that stays, shape (3,).
        shift: duration of the weight shift [s].
        steps: footholds, the next first.
        begins: DCM with which it begins, shape (2,) [m]: the weight first goes to the foot that is to swing, as far as
            that takes, or nearly as far as that foot. The plan begins with a jump of the DCM if None.
    """
    single, shifting = round(gait.single_support / dt), round(shift / dt)
    parts = [_ramp(zmp, support[:2], shifting), _hold(support[:2], single)]
    here = support
    for step in steps[:-1]:
        parts += [_ramp(here[:2], step.pose[:2], round(gait.double_support / dt)), _hold(step.pose[:2], single)]
        here = step.pose
    middle = 0.5 * (here[:2] + steps[-1].pose[:2])
    parts += [_ramp(here[:2], middle, round(gait.last_shift / dt)), _hold(middle, round(_REST / dt))]
    trajectory = np.vstack(parts)
    dcm = plan_dcm(trajectory, omega, dt)
    if begins is not None and shifting:
        fades = 1.0 - (np.arange(len(trajectory)) / shifting).clip(0.0, 1.0)
        gains = plan_dcm(np.column_stack([fades, fades]), omega, dt)
        back = (zmp - support[:2]) * _UNLOADED
        needed = float((begins - dcm[0]) @ back) / max(float(gains[0, 0] * (back @ back)), 1e-9)
        first = min(max(needed, 0.0), 1.0) * back
        trajectory, dcm = trajectory + fades[:, None] * first, dcm + gains * first
    return DcmPlan(trajectory, dcm)


def plan_settle(gait: GaitConfig, omega: float, dt: float, *, zmp: Array, middle: Array) -> DcmPlan:
    """Plan from where the ZMP is to rest over the middle between the feet.

    Args:
        gait: the robot's gait.
        omega: [1/s].
        dt: [s].
        zmp: where the ZMP is now, shape (2,) [m].
        middle: between the feet, shape (2,) [m].
    """
    trajectory = np.vstack([_ramp(zmp, middle, round(gait.last_shift / dt)), _hold(middle, round(_REST / dt))])
    return DcmPlan(trajectory, plan_dcm(trajectory, omega, dt))


def _ramp(start: Array, end: Array, count: int) -> Array:
    share = (np.arange(count) + 1)[:, None] / max(count, 1)
    return np.asarray(start + (end - start) * share)


def _hold(point: Array, count: int) -> Array:
    return np.repeat(point[None], count, axis=0)
