"""Rotations and rigid motions, for every layer, in plain floats because control needs them at 200 Hz.

Quaternions are (w, x, y, z). A pose is (x, y, z, qw, qx, qy, qz). A twist is (translation, rotation vector); its
exponential is the pose it leads to in unit time (Sola, Deray, Atchuthan, "A micro Lie theory for state estimation in
robotics", 2018, appendix D).
"""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.messages import Array


def clamp(values: Array, low: Array | float, high: Array | float, out: Array | None = None) -> Array:
    """Return values, in ``out`` if given, none below ``low`` or above ``high``: ``np.clip`` in a third of its time."""
    return np.minimum(np.maximum(values, low), high, out=out)


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


def quaternion(matrix: Array) -> Array:
    """Return the unit quaternion, shape (4,), of a rotation matrix, shape (3, 3): the one with w >= 0.

    The largest part is found first, and the others by it (Shepperd, "Quaternion from rotation matrix", 1978).
    """
    (a, b, c), (d, e, f), (g, h, i) = matrix.tolist()
    squares = (1 + a + e + i, 1 + a - e - i, 1 - a + e - i, 1 - a - e + i)  # of w, x, y, z, four times
    largest = max(range(4), key=squares.__getitem__)
    rows = (
        (squares[0], h - f, c - g, d - b),
        (h - f, squares[1], b + d, c + g),
        (c - g, b + d, squares[2], f + h),
        (d - b, c + g, f + h, squares[3]),
    )
    found: Array = np.array(rows[largest])
    return found * (math.copysign(1.0, found[0]) / math.sqrt(found @ found))


def quaternion_product(first: Array, second: Array) -> Array:
    """Return the quaternion, shape (4,), that turns as ``second`` does and then as ``first`` does."""
    return np.array(_product(first.tolist(), second.tolist()))


def turn_between(start: Array, end: Array) -> Array:
    """Return the rotation vector, shape (3,), that turns ``start`` into ``end``, in the frame of both; quaternions."""
    inverse = start * [1.0, -1.0, -1.0, -1.0]
    return log(np.concatenate([[0.0, 0.0, 0.0], quaternion_product(end, inverse)]))[3:]


def turned(orientation: Array, turn: Array) -> Array:
    """Return a quaternion, shape (4,), after it was turned by a rotation vector, shape (3,), of its outer frame."""
    after = quaternion_product(exp(np.concatenate([[0.0, 0.0, 0.0], turn]))[3:], orientation)
    return np.asarray(after / math.sqrt(after @ after))


def turn_of_axis(start: Array, end: Array) -> Array:
    """Return the shortest rotation vector, shape (3,), that turns a unit vector into another one."""
    across = np.array(_cross(start.tolist(), end.tolist()))
    sine, cosine = math.sqrt(across @ across), float(start @ end)
    if sine > _SMALL:
        return np.asarray(across * (math.atan2(sine, cosine) / sine))
    if cosine > 0:
        return across
    aside = np.array(_cross(start.tolist(), np.eye(3)[int(np.argmin(np.abs(start)))].tolist()))
    return np.asarray(aside * (math.pi / math.sqrt(aside @ aside)))


def yaw_of(quaternion: Array) -> float:
    """Return how far a quaternion, shape (4,), wxyz, turns about the vertical: its yaw, after pitch and roll [rad]."""
    w, x, y, z = quaternion.tolist()
    return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def heading_of(turn: Array) -> float:
    """Return where the first axis of a rotation matrix, shape (3, 3), points to, seen from above [rad]."""
    return math.atan2(turn.item(1, 0), turn.item(0, 0))


def planar_pose(x: float, y: float, z: float, yaw: float) -> Array:
    """Return the pose, shape (7,), of something upright at a position, turned by ``yaw``."""
    return np.array([x, y, z, math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])


def view_along(yaw: float, pitch: float) -> Array:
    """Return the quaternion, shape (4,), of what looks along a yaw and then a pitch [rad]."""
    return np.array(_view_along(yaw, pitch))


def pose_product(first: Array, second: Array) -> Array:
    """Return the pose, shape (7,), of ``second`` when it is given in the frame of ``first``."""
    a, b = first.tolist(), second.tolist()
    x, y, z = _turned(a[3:], b[:3])
    return np.array([a[0] + x, a[1] + y, a[2] + z, *_product(a[3:], b[3:])])


def pose_inverse(pose: Array) -> Array:
    """Return the pose, shape (7,), of the world as seen from ``pose``."""
    px, py, pz, w, qx, qy, qz = pose.tolist()
    turn = [w, -qx, -qy, -qz]
    x, y, z = _turned(turn, [px, py, pz])
    return np.array([-x, -y, -z, *turn])


def exp(twist: Array) -> Array:
    """Return the pose, shape (7,), that a twist, shape (6,), leads to."""
    values = twist.tolist()
    way, turn = values[:3], values[3:]
    angle = math.sqrt(turn[0] ** 2 + turn[1] ** 2 + turn[2] ** 2)
    if angle < _SMALL:
        half, b, c = 0.5, 0.5, 1 / 6
    else:
        half = math.sin(angle / 2) / angle
        b, c = (1 - math.cos(angle)) / angle**2, (angle - math.sin(angle)) / angle**3
    once = _cross(turn, way)
    twice = _cross(turn, once)
    position = [w + b * o + c * t for w, o, t in zip(way, once, twice, strict=True)]
    return np.array([*position, math.cos(angle / 2), half * turn[0], half * turn[1], half * turn[2]])


def log(pose: Array) -> Array:
    """Return the twist, shape (6,), whose exponential is ``pose``, with a turn of at most half a revolution."""
    px, py, pz, w, qx, qy, qz = pose.tolist()
    sine = math.sqrt(qx * qx + qy * qy + qz * qz)
    angle = 2 * math.atan2(sine, abs(w))
    scale = math.copysign(2.0 if angle < _SMALL else angle / sine, w)
    turn = [scale * qx, scale * qy, scale * qz]
    d = 1 / 12 if angle < _SMALL else (1 - angle * math.sin(angle) / (2 * (1 - math.cos(angle)))) / angle**2
    way = [px, py, pz]
    once = _cross(turn, way)
    twice = _cross(turn, once)
    return np.array([*(p - 0.5 * o + d * t for p, o, t in zip(way, once, twice, strict=True)), *turn])


_SMALL = 1e-6  # rad; below it the series' first terms are exact to the last bit


def _view_along(yaw: float, pitch: float) -> list[float]:
    cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    return [cy * cp, -sy * sp, cy * sp, sy * cp]


def _product(first: list[float], second: list[float]) -> list[float]:
    a, b, c, d = first
    e, f, g, h = second
    return [
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    ]


def _turned(quaternion: list[float], vector: list[float]) -> list[float]:
    """Return v + 2 w (u x v) + 2 u x (u x v) for the quaternion (w, u)."""
    w, axis = quaternion[0], quaternion[1:]
    once = _cross(axis, vector)
    twice = _cross(axis, once)
    return [v + 2 * (w * o + t) for v, o, t in zip(vector, once, twice, strict=True)]


def _cross(a: list[float], b: list[float]) -> list[float]:
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
