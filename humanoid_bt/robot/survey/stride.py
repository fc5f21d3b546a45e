"""How a robot may stride: whether its feet can roll over the ground, and how far its knees can straighten."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array
from humanoid_bt.robot.survey.limbs import Limbs, Surveyor

_WIDE = 0.05  # m of a sole: a narrower one that lands by its heel on an edge, of a plate, tips over
_PITCH, _SPARE = 0.15, 0.05  # rad by which a foot that leaves or lands is pitched, and that its ankle can turn more
_STRAIGHTENED = 0.55  # share of what bent knees take from the legs' length, ...
_LEAST, _HIGHEST = (
    0.005,
    0.02,
)  # ...as m of rise that are worth it, and that feet on uneven ground still reach down from


def stride(
    surveyor: Surveyor, limbs: Limbs, home: Mapping[int, float], standing: mujoco.MjData, width: float
) -> dict[str, float]:
    """Return numbers of the gait that roll its feet and straighten its knees, as far as its legs can.

    Args:
        surveyor: of the model.
        limbs: the robot's.
        home: angles in which it stands, joint -> rad.
        standing: that posture.
        width: of a sole [m].
    """
    found: dict[str, float] = {}
    pitches = [[joint for joint in leg.joints if surveyor.turns_about(joint, 1)] for leg in limbs.legs.values()]
    if any(len(leg) < 3 for leg in pitches):  # hip, knee and ankle
        return found
    if all(_turns(surveyor.model, leg[-1], home) for leg in pitches):
        found["toe_off"] = _PITCH
        if width >= _WIDE:
            found["heel_strike"] = _PITCH
    rise = min(_HIGHEST, *(_STRAIGHTENED * _bent(standing.xanchor[leg]) for leg in pitches))
    return found | ({"rise": round(rise, 3)} if rise > _LEAST else {})


def _turns(model: mujoco.MjModel, ankle: int, home: Mapping[int, float]) -> bool:
    """Return whether an ankle can pitch its foot far enough both ways from how the robot stands."""
    room = np.abs(model.jnt_range[ankle] - home.get(ankle, 0.0)).min()
    return not model.jnt_limited[ankle] or bool(room >= _PITCH + _SPARE)


def _bent(joints: Array) -> float:
    """Return how much longer a leg would be if it were straight, seen from its side [m].

    Args:
        joints: places of those that pitch, from the hip to the ankle, world frame, shape (n, 3) [m].
    """
    side = joints[:, ::2]
    return float(np.linalg.norm(np.diff(side, axis=0), axis=1).sum() - np.linalg.norm(side[-1] - side[0]))
