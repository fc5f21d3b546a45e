"""Rotations as tuples of floats, for functions that are machine code: quaternions (w, x, y, z)."""

from __future__ import annotations

import math

from humanoid_bt.core.compiled import inlined
from humanoid_bt.core.messages import Array

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_NO_TURN = 1e-15  # rad; less turns nothing


@inlined
def cross(first: Vector, second: Vector) -> Vector:
    """Return the cross product of two vectors."""
    a, b, c = first
    d, e, f = second
    return b * f - c * e, c * d - a * f, a * e - b * d


@inlined
def product(first: Quaternion, second: Quaternion) -> Quaternion:
    """Return the quaternion that turns as ``second`` does and then as ``first`` does."""
    a, b, c, d = first
    e, f, g, h = second
    return (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )


@inlined
def turned(quaternion: Quaternion, vector: Vector) -> Vector:
    """Return a vector turned by a quaternion."""
    w, x, y, z = quaternion
    a, b, c = vector
    d, e, f = cross((x, y, z), vector)
    g, h, i = cross((x, y, z), (d, e, f))
    return a + 2 * (w * d + g), b + 2 * (w * e + h), c + 2 * (w * f + i)


@inlined
def of_vector(x: float, y: float, z: float) -> Quaternion:
    """Return the quaternion of a rotation vector [rad]."""
    angle = math.sqrt(x * x + y * y + z * z)
    share = math.sin(angle / 2) / angle if angle > _NO_TURN else 0.5
    return math.cos(angle / 2), x * share, y * share, z * share


@inlined
def to_vector(quaternion: Quaternion) -> Vector:
    """Return the rotation vector of a quaternion, of at most half a revolution [rad]."""
    w, x, y, z = quaternion
    sine = math.sqrt(x * x + y * y + z * z)
    scale = 2 * math.atan2(sine, abs(w)) / sine if sine > _NO_TURN else 2.0
    if w < 0:
        scale = -scale
    return x * scale, y * scale, z * scale


@inlined
def view_along(yaw: float, pitch: float) -> Quaternion:
    """Return the quaternion of what looks along a yaw and then a pitch [rad]."""
    cy, sy, cp, sp = math.cos(yaw / 2), math.sin(yaw / 2), math.cos(pitch / 2), math.sin(pitch / 2)
    return cy * cp, -sy * sp, cy * sp, sy * cp


@inlined
def leaning(heading: float, lean: float, yaw: float) -> Quaternion:
    """Return the quaternion of what leans ahead along a heading, and turns about its own axis [rad]."""
    return product(view_along(heading, lean), (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))


@inlined
def tilted(quaternion: Quaternion, x: float, y: float) -> Quaternion:
    """Return a quaternion turned by small angles about the world's x and y [rad]."""
    return product((math.sqrt(1 - 0.25 * (x * x + y * y)), 0.5 * x, 0.5 * y, 0.0), quaternion)


@inlined
def between(start: Quaternion, end: Quaternion) -> Vector:
    """Return the rotation vector, in the frame of both, that turns one orientation into another [rad]."""
    w, x, y, z = start
    return to_vector(product(end, (w, -x, -y, -z)))


@inlined
def of_matrix(m: Array) -> Quaternion:
    """Return the unit quaternion of a rotation matrix whose nine numbers come row by row, shape (9,).

    The largest part is found first, and the others by it (Shepperd, "Quaternion from rotation matrix", 1978).
    """
    w, x = 1 + m[0] + m[4] + m[8], 1 + m[0] - m[4] - m[8]  # squares of the parts, four times
    y, z = 1 - m[0] + m[4] - m[8], 1 - m[0] - m[4] + m[8]
    a, b, c = m[7] - m[5], m[2] - m[6], m[3] - m[1]
    d, e, f = m[1] + m[3], m[5] + m[7], m[2] + m[6]
    largest = max(w, x, y, z)
    scale = 0.5 / math.sqrt(largest)
    if w == largest:
        return w * scale, a * scale, b * scale, c * scale
    if x == largest:
        return a * scale, x * scale, d * scale, f * scale
    if y == largest:
        return b * scale, d * scale, y * scale, e * scale
    return c * scale, f * scale, e * scale, z * scale
