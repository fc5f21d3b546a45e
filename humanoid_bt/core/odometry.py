"""Where a robot really is beside where it believes to be."""

from __future__ import annotations

import math

from humanoid_bt.core.geometry import yaw_of
from humanoid_bt.core.messages import State, Truth


def truth_of(state: State) -> Truth:
    """Return where a robot is that knows exactly where it is."""
    return Truth(
        state.time,
        state.base_position,
        state.base_quaternion,
        state.gaze_position,
        state.gaze_direction,
        state.joint_positions,
    )


def odometry_error(state: State, truth: Truth) -> tuple[float, float]:
    """Return how far the base is from where it is believed to be [m], seen from above, and how far turned [rad]."""
    off = state.base_position - truth.base_position
    turned = math.remainder(yaw_of(state.base_quaternion) - yaw_of(truth.base_quaternion), math.tau)
    return math.hypot(off[0], off[1]), abs(turned)
