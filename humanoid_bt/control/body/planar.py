"""Poses in the ground plane: arrays (x [m], y [m], yaw [rad]), and turns of plane vectors."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import Array


def wrap(angle: float) -> float:
    """Return the same angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def rotate(vector: Array, yaw: float) -> Array:
    """Turn a plane vector, shape (2,), by ``yaw``."""
    x, y = vector.tolist()
    return np.array(_turned(x, y, yaw))


def ahead(pose: Array, x: float, y: float, yaw: float = 0.0) -> Array:
    """Return the pose that lies at (x, y, yaw) as seen from ``pose``."""
    from_x, from_y, heading = pose.tolist()
    cos, sin = math.cos(heading), math.sin(heading)
    return np.array((from_x + cos * x - sin * y, from_y + sin * x + cos * y, heading + yaw))


def seen_from(pose: Array, point: Array) -> Array:
    """Return a point's plane coordinates, shape (2,), as seen from ``pose``."""
    (at_x, at_y, heading), (x, y) = pose.tolist(), point[:2].tolist()
    return np.array(_turned(x - at_x, y - at_y, -heading))


def middle(left: Array, right: Array) -> Array:
    """Return the pose halfway between two."""
    pose = np.empty(3)
    _middle(pose, left, right)
    return pose


@inlined
def put_between(pose: Array, left: Array, right: Array) -> None:
    """Write the pose halfway between two; each of shape (3,)."""
    pose[0], pose[1] = 0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1])
    pose[2] = left[2] + 0.5 * ((right[2] - left[2] + math.pi) % (2 * math.pi) - math.pi)


@compiled("void(f8[::1], f8[::1], f8[::1])")
def _middle(pose: Array, left: Array, right: Array) -> None:
    put_between(pose, left, right)


def _turned(x: float, y: float, yaw: float) -> tuple[float, float]:
    cos, sin = math.cos(yaw), math.sin(yaw)
    return cos * x - sin * y, sin * x + cos * y
