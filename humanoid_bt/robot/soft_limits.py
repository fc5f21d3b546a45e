"""Soft limits of joints: those of the model, less a margin."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array


def soft_limits(model: mujoco.MjModel, joints: Sequence[int], margin: float) -> tuple[Array, Array]:
    """Return the lower and upper soft limits of joints, shape (len(joints),) each [rad]; infinite where it has none.

    Args:
        model: of the robot.
        joints: of the model.
        margin: by which they lie inside the model's limits, but at most a quarter of a joint's range [rad].
    """
    limited = model.jnt_limited[joints].astype(bool)
    low, high = model.jnt_range[joints].T
    inside = np.minimum(margin, (high - low) / 4)
    return np.where(limited, low + inside, -np.inf), np.where(limited, high - inside, np.inf)
