"""Copies of the numbers that control works on, all at once: a state is made of them."""

from __future__ import annotations

import numpy as np

from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import Array, Estimate, JointCommand


def copies(
    estimate: Estimate, command: JointCommand, dynamics: RobotDynamics, stance: Array
) -> tuple[Array, Array, Array]:
    """Return copies, into which nobody can write.

    Args:
        estimate, command, dynamics: what is copied.
        stance: shape (3,).

    Returns:
        Of the joints, shape (5, nj): position, velocity, torque, position and velocity of the setpoint. Points, shape
        (8 + hands, 3): the base's position, velocity and angular velocity, the centre of mass, its velocity, the
        stance, the eyes, their direction of view, the palms. Quaternions, shape (1 + hands, 4): of the base and the
        palms.
    """
    hands = len(dynamics.sides)
    joints, points, turns = np.empty((5, len(command.position))), np.empty((8 + hands, 3)), np.empty((1 + hands, 4))
    _copy(
        joints, points, turns, estimate.qpos, estimate.qvel, estimate.joint_torque, command.position, command.velocity,
        dynamics.com, dynamics.com_velocity,
    )  # fmt: skip
    points[5] = stance
    dynamics.copy_sites(points[6:], turns[1:])
    for copied in (joints, points, turns):
        copied.setflags(write=False)
    return joints, points, turns


@compiled(
    "void(f8[:, ::1], f8[:, ::1], f8[:, ::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1])",
)
def _copy(
    joints: Array,
    points: Array,
    turns: Array,
    qpos: Array,
    qvel: Array,
    torque: Array,
    position: Array,
    velocity: Array,
    com: Array,
    com_velocity: Array,
) -> None:
    """See :func:`copies`: what is written first, but for stance and sites, and then what is copied."""
    for joint in range(joints.shape[1]):
        joints[0, joint], joints[1, joint], joints[2, joint] = qpos[7 + joint], qvel[6 + joint], torque[joint]
        joints[3, joint], joints[4, joint] = position[joint], velocity[joint]
    for i in range(3):
        points[0, i], points[1, i], points[2, i] = qpos[i], qvel[i], qvel[3 + i]
        points[3, i], points[4, i] = com[i], com_velocity[i]
    for i in range(4):
        turns[0, i] = qpos[3 + i]
