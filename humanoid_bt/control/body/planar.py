"""Poses in the ground plane: arrays (x [m], y [m], yaw [rad]), and turns of plane vectors."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.messages import Array


def wrap(angle: float) -> float:
    """Return the same angle in [-pi, pi)."""
    return (angle + math.pi) % (2 * math.pi) - math.pi


def rotate(vector: Array, yaw: float) -> Array:
    """Turn a plane vector, shape (2,), by ``yaw``."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return np.array([cos * vector[0] - sin * vector[1], sin * vector[0] + cos * vector[1]])


def ahead(pose: Array, x: float, y: float, yaw: float = 0.0) -> Array:
    """Return the pose that lies at (x, y, yaw) as seen from ``pose``."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return np.array([pose[0] + cos * x - sin * y, pose[1] + sin * x + cos * y, pose[2] + yaw])


def seen_from(pose: Array, point: Array) -> Array:
    """Return a point's plane coordinates, shape (2,), as seen from ``pose``."""
    return rotate(point[:2] - pose[:2], -pose[2])


def middle(left: Array, right: Array) -> Array:
    """Return the pose halfway between two."""
    yaw = left[2] + 0.5 * wrap(right[2] - left[2])
    return np.array([0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1]), yaw])


def inside(pose: Array, point: Array, half_length: float, half_width: float) -> Array:
    """Return the point of a rectangle around ``pose`` that is nearest to ``point``, both shape (2,)."""
    x, y = seen_from(pose, point)
    x = min(max(x, -half_length), half_length)
    y = min(max(y, -half_width), half_width)
    return ahead(pose, x, y)[:2]
