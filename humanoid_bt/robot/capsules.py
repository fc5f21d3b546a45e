"""The shape of a robot as capsules: those of ``robot.yaml``, else made from the model's shapes that touch."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel

STICKS_OUT = 0.008
"""At most so much of a shape of the model is outside of its capsules [m]."""

_BULGE = 0.015  # m at most that a capsule is thicker than what it covers
_POINTS = 13  # along an edge of a box
_SPACING = 0.01  # m between points on a mesh

_Types = mujoco.mjtGeom


@dataclass(frozen=True)
class Capsule:
    """What is within a radius of the line between two points of a body.

    Attributes:
        body: number of the body in the model.
        ends: of the line, in the body's frame, shape (2, 3) [m].
        radius: [m].
    """

    body: int
    ends: Array
    radius: float


def capsules(robot: RobotModel) -> list[Capsule]:
    """Return the robot's shape: of each body its capsules of ``robot.yaml``, else such as cover its collision geoms."""
    model = robot.model
    given = [
        Capsule(model.body(capsule.body).id, np.array([capsule.start, capsule.end]), capsule.radius)
        for capsule in robot.config.collision.capsules
    ]
    done = {capsule.body for capsule in given}
    for geom in range(model.ngeom):
        body = int(model.geom_bodyid[geom])
        if body not in done and (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            turn = np.empty(9)
            mujoco.mju_quat2Mat(turn, model.geom_quat[geom])
            for ends, radius in _shape(model, geom):
                given.append(Capsule(body, model.geom_pos[geom] + ends @ turn.reshape(3, 3).T, radius))
    return given


def _shape(model: mujoco.MjModel, geom: int) -> Iterator[tuple[Array, float]]:
    """Yield ends and radius of the capsules for a geom, in its frame."""
    kind, (radius, half, _) = _Types(int(model.geom_type[geom])), model.geom_size[geom].tolist()
    if kind == _Types.mjGEOM_SPHERE:
        yield np.zeros((2, 3)), radius
    elif kind == _Types.mjGEOM_CAPSULE:
        yield np.array([[0, 0, -half], [0, 0, half]]), radius
    else:
        yield from _covering(_surface(model, geom))


def _surface(model: mujoco.MjModel, geom: int) -> Array:
    """Return points on a geom, shape (n, 3), in its frame [m]; of a mesh on its convex hull, which is what touches."""
    kind, size = _Types(int(model.geom_type[geom])), model.geom_size[geom]
    if kind == _Types.mjGEOM_MESH:
        return _hull(model, int(model.geom_dataid[geom]))
    steps = np.linspace(-1, 1, _POINTS)
    points = np.array(np.meshgrid(steps, steps, steps)).reshape(3, -1).T
    points = points[np.abs(points).max(axis=1) == 1]
    if kind == _Types.mjGEOM_ELLIPSOID:
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    elif kind == _Types.mjGEOM_CYLINDER:
        across = points[:, :2]
        across *= (np.abs(across).max(axis=1) / np.maximum(np.linalg.norm(across, axis=1), 1e-9))[:, None]
        return np.asarray(points * [size[0], size[0], size[1]])
    return np.asarray(points * size)


def _hull(model: mujoco.MjModel, mesh: int) -> Array:
    vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
    start = int(model.mesh_graphadr[mesh])
    if start < 0:
        return np.asarray(vertices)
    count, faces = model.mesh_graph[start : start + 2].tolist()  # then: edges, and 3 vertices of each face
    first = start + 2 + 3 * count + 3 * faces
    corners = vertices[model.mesh_graph[first : first + 3 * faces].reshape(faces, 3)]
    points: list[Array] = [np.asarray(vertices[model.mesh_graph[start + 2 + count : start + 2 + 2 * count]])]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    for (one, other, third), edge in zip(corners[edges > _SPACING], edges[edges > _SPACING], strict=True):
        steps = int(np.ceil(edge / _SPACING))
        shares = [(i / steps, k / steps) for i in range(steps + 1) for k in range(steps + 1 - i)]
        points.append(one + np.array(shares) @ np.array([other - one, third - one]))
    return np.concatenate(points)


def _covering(points: Array) -> Iterator[tuple[Array, float]]:
    """Yield capsules along the longest side of points: one, or bundles of thinner ones until they fit."""
    low, high = points.min(axis=0), points.max(axis=0)
    order = np.argsort(low - high)  # the longest side first
    points, low, high = points[:, order], low[order][1:], high[order][1:]
    counts = np.array([1, 1])
    while True:
        half = (high - low) / counts / 2
        bundle = [
            _capsule(points[_within(points, low + (2 * np.array(place) + 1) * half, half)])
            for place in np.ndindex(*counts)
        ]
        fitting = [capsule for capsule in bundle if capsule]
        if max(radius for _, radius in fitting) - half.min() <= _BULGE:
            break
        counts[half.argmax()] += 1
    for ends, radius in fitting:
        yield ends[:, np.argsort(order)], radius


def _within(points: Array, middle: Array, half: Array) -> NDArray[np.bool_]:
    """Return which points are in the bundle's cell around a middle, those on its border included."""
    return np.asarray((np.abs(points[:, 1:] - middle) <= half + 1e-9).all(axis=1))


def _capsule(points: Array) -> tuple[Array, float] | None:
    """Return the ends and the radius of a capsule along the first axis of points; None if there are none."""
    if not len(points):
        return None
    middle = (points.min(axis=0) + points.max(axis=0))[1:] / 2
    aside = np.linalg.norm(points[:, 1:] - middle, axis=1)
    radius = max(float(aside.max()) - STICKS_OUT / 2, STICKS_OUT / 2)
    covered = np.sqrt(np.maximum((radius + STICKS_OUT) ** 2 - aside**2, 0.0))  # ahead of an end and behind it
    low, high = float((points[:, 0] + covered).min()), float((points[:, 0] - covered).max())
    if low > high:
        low = high = (low + high) / 2
    return np.array([[low, *middle], [high, *middle]]), radius
