"""What drives give."""

from __future__ import annotations

import numpy as np

from humanoid_bt.core.messages import Array, JointCommand, Reading


def given(command: JointCommand, before: Reading, after: Reading, limit: Array) -> Array:
    """Return what drives with these limits give in a servo period, shape (nj,) [Nm].

    Physics integrates their damping implicitly: it is that of the velocity at the end, but of a drive at its limit.

    Args:
        command: they have it.
        before, after: what exact sensors said at the beginning and at the end.
        limit: of the torques, shape (nj,) [Nm].
    """
    held = command.stiffness * (command.position - before.joint_position) + command.torque
    begins, ends = (held + command.damping * (command.velocity - at.joint_velocity) for at in (before, after))
    return np.where(np.abs(begins) < limit, ends, np.clip(begins, -limit, limit))
