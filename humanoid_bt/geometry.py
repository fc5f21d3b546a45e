"""Rotations and rigid motions, for every layer, in plain floats because control needs them at 200 Hz.

Quaternions are (w, x, y, z). A pose is (x, y, z, qw, qx, qy, qz). A twist is (translation, rotation vector); its
exponential is the pose it leads to in unit time (Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in
robotics", 2018, appendix D).
"""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.messages import Array


def rotation_matrix(quaternion: Array) -> Array:
    """Return the matrix, shape (3, 3), that turns vectors as a unit quaternion, shape (4,), does."""
    w, x, y, z = quaternion.tolist()
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def planar_pose(x: float, y: float, z: float, yaw: float) -> Array:
    """Return the pose, shape (7,), of something upright at a position, turned by ``yaw``."""
    return np.array([x, y, z, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])


def quaternion_product(first: Array, second: Array) -> Array:
    """Return the quaternion, shape (4,), that turns as ``second`` and then ``first`` do."""
    a, b, c, d = first.tolist()
    e, f, g, h = second.tolist()
    return np.array(
        [
            a * e - b * f - c * g - d * h,
            a * f + b * e + c * h - d * g,
            a * g - b * h + c * e + d * f,
            a * h + b * g - c * f + d * e,
        ]
    )


def pose_product(first: Array, second: Array) -> Array:
    """Return the pose, shape (7,), of ``second`` when it is given in the frame of ``first``."""
    position = first[:3] + rotation_matrix(first[3:]) @ second[:3]
    return np.concatenate([position, quaternion_product(first[3:], second[3:])])


def pose_inverse(pose: Array) -> Array:
    """Return the pose, shape (7,), of the world as seen from ``pose``."""
    turn = np.array([pose[3], -pose[4], -pose[5], -pose[6]])
    return np.concatenate([-(rotation_matrix(turn) @ pose[:3]), turn])


def exp(twist: Array) -> Array:
    """Return the pose, shape (7,), that a twist, shape (6,), leads to."""
    turn = twist[3:]
    angle = math.sqrt(turn @ turn)
    if angle < _SMALL:
        half, b, c = 0.5, 0.5, 1 / 6
    else:
        half = math.sin(angle / 2) / angle
        b, c = (1 - math.cos(angle)) / angle**2, (angle - math.sin(angle)) / angle**3
    once = _cross(turn, twist[:3])
    position = twist[:3] + b * once + c * _cross(turn, once)
    return np.concatenate([position, [math.cos(angle / 2)], half * turn])


def log(pose: Array) -> Array:
    """Return the twist, shape (6,), whose exponential is ``pose``, with a turn of at most half a revolution."""
    w = pose[3]
    axis = pose[4:] if w >= 0 else -pose[4:]
    sine = math.sqrt(axis @ axis)
    angle = 2 * math.atan2(sine, abs(w))
    if angle < _SMALL:
        turn, d = 2 * axis, 1 / 12
    else:
        turn = axis * (angle / sine)
        d = (1 - angle * math.sin(angle) / (2 * (1 - math.cos(angle)))) / angle**2
    once = _cross(turn, pose[:3])
    return np.concatenate([pose[:3] - 0.5 * once + d * _cross(turn, once), turn])


_SMALL = 1e-6  # rad; below it the series' first terms are exact to the last bit


def _cross(a: Array, b: Array) -> Array:
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
