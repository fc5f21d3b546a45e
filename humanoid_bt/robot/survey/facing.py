"""Whether x of the base points ahead, by the legs: knees fold backward, and feet are longer ahead of the ankle."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array, Side
from humanoid_bt.core.texts import listed
from humanoid_bt.robot.footprint import footprint_in
from humanoid_bt.robot.survey.limbs import Limb, Limbs, NoHumanoidError, Surveyor

_FOLDED = 0.1  # of the leg, by which it must be shorter at one limit of the knee than at the other
_LONGER = 0.05  # of half of a sole, by which its middle must be beside the ankle
_SHORT = 0.005  # m, half of a sole that is a point or a line


def doubts(surveyor: Surveyor, limbs: Limbs, soles: Mapping[Side, Array]) -> str:
    """Return what of the legs says that x of the base does not point ahead, "" for nothing.

    Args:
        surveyor: of the model.
        limbs: the robot's.
        soles: their axes in the frames of the feet, shape (3, 3).

    Raises:
        NoHumanoidError: both knees and feet say so.
    """
    knees = all(_folds(surveyor, leg) < 0 for leg in limbs.legs.values())
    feet = all(_longer(surveyor, leg, soles[side]) < 0 for side, leg in limbs.legs.items())
    said = listed(list(_said(knees, feet)))
    if knees and feet:
        base = surveyor.model.body(limbs.base).name
        raise NoHumanoidError(f"{base!r} faces backward: {said}; in its frame x must point ahead, y to the left, z up")
    return said


def _said(knees: bool, feet: bool) -> Iterator[str]:
    if knees:
        yield "the knees fold ahead"
    if feet:
        yield "the feet are longer behind the ankles"


def _folds(surveyor: Surveyor, leg: Limb) -> float:
    """Return which way the knee takes the foot as it folds: 1 back, as a person's does, -1 ahead, 0 if that is open."""
    model, data = surveyor.model, mujoco.MjData(surveyor.model)
    pitches = [j for j in leg.joints if surveyor.turns_about(j, 1)]
    if len(pitches) < 3 or not model.jnt_limited[pitches[1]]:
        return 0.0
    hip, knee, ankle = pitches[0], pitches[1], pitches[-1]
    lengths: list[float] = []
    for limit in model.jnt_range[knee].tolist():
        data.qpos[:] = model.qpos0
        data.qpos[model.jnt_qposadr[knee]] = limit
        mujoco.mj_kinematics(model, data)
        lengths.append(float(np.linalg.norm(data.xanchor[ankle] - data.xanchor[hip])))
    low, high = lengths
    return float(np.sign(surveyor.axis(knee)[1] * (low - high))) if abs(low - high) > _FOLDED * max(lengths) else 0.0


def _longer(surveyor: Surveyor, leg: Limb, axes: Array) -> float:
    """Return where a sole is longer: 1 ahead of the ankle, -1 behind it, 0 if that is open."""
    model, data = surveyor.model, surveyor.data
    pitches = [j for j in leg.joints if surveyor.turns_about(j, 1)]
    foot = footprint_in(model, data, leg.body, axes)
    if foot is None or not pitches or foot.half[0] < _SHORT:
        return 0.0
    ankle = data.xmat[leg.body].reshape(3, 3).T @ (data.xanchor[pitches[-1]] - data.xpos[leg.body])
    ahead = float((foot.centre - ankle) @ axes[:, 0])
    return float(np.sign(ahead)) if abs(ahead) > _LONGER * foot.half[0] else 0.0
