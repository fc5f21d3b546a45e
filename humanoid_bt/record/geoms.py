"""MuJoCo geoms as rerun shapes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import rerun as rr

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array

_TILE = 0.5  # side of a floor tile [m]: a step is about a third of it
_FLOOR_HALF_SIZE = 8.0  # a plane is infinite for contacts; this much of it is drawn [m]
_FLOOR_COLORS = ((88, 98, 112), (74, 83, 96))
_DARKEST = 0.16  # the viewer's light is weak: a black robot would vanish against the background
_HIDDEN_COLOR = (205, 210, 218)
PRIMITIVES = (rr.Ellipsoids3D, rr.Capsules3D, rr.Cylinders3D, rr.Boxes3D)
"""Archetypes whose look is their own, see :func:`look`."""

_INVISIBLE = 0.02  # alpha below which a geom is not drawn


def is_drawn(model: mujoco.MjModel, geom: int) -> bool:
    """Return whether a geom is shown: visual groups 0 to 2, as MuJoCo's own viewer does, and not transparent."""
    return bool(model.geom_group[geom] <= 2 and _rgba(model, geom)[3] > _INVISIBLE)


def shape(model: mujoco.MjModel, geom: int) -> Any | None:
    """Return a geom as a rerun archetype in the geom's own frame, None for a kind that rerun has no shape for.

    Primitives lack their look, see :func:`look`.
    """
    draw = _SHAPES.get(int(model.geom_type[geom]))
    return draw(model, geom) if draw else None


def look(model: mujoco.MjModel, geom: int, *, hidden: bool = False) -> dict[str, Any]:
    """Return colour and fill of a primitive; hidden it is an outline that can be seen through."""
    fill = rr.components.FillMode
    if hidden:
        return {"colors": [_HIDDEN_COLOR], "fill_mode": [fill.TransparentFillMajorWireframe]}
    return {"colors": [_color(model, geom)], "fill_mode": [fill.Solid]}


def height(model: mujoco.MjModel, body: int) -> tuple[float, float]:
    """Return how far a body's own geoms reach down and up from its origin [m]."""
    low = high = 0.0
    for geom in np.flatnonzero(model.geom_bodyid == body):
        middle, half = model.geom_aabb[geom].reshape(2, 3)
        turn = rotation_matrix(model.geom_quat[geom])
        z, reach = model.geom_pos[geom][2] + (turn @ middle)[2], (np.abs(turn) @ half)[2]
        low, high = min(low, z - reach), max(high, z + reach)
    return low, high


def _rgba(model: mujoco.MjModel, geom: int) -> Array:
    material = model.geom_matid[geom]
    return np.asarray(model.geom_rgba[geom] if material < 0 else model.mat_rgba[material])


def _color(model: mujoco.MjModel, geom: int) -> Any:
    rgba = np.clip(_rgba(model, geom), 0, 1)
    rgba[:3] = _DARKEST + (1 - _DARKEST) * rgba[:3]
    return np.round(rgba * 255).astype(np.uint8)


def _sphere(model: mujoco.MjModel, geom: int) -> Any:
    return rr.Ellipsoids3D(half_sizes=[[model.geom_size[geom][0]] * 3])


def _ellipsoid(model: mujoco.MjModel, geom: int) -> Any:
    return rr.Ellipsoids3D(half_sizes=[model.geom_size[geom]])


def _capsule(model: mujoco.MjModel, geom: int) -> Any:
    radius, half, _ = model.geom_size[geom]
    start = [[0, 0, -half]]  # rerun's capsule starts at its origin, MuJoCo's is centred
    return rr.Capsules3D(lengths=[2 * half], radii=[radius], translations=start)


def _cylinder(model: mujoco.MjModel, geom: int) -> Any:
    radius, half, _ = model.geom_size[geom]
    return rr.Cylinders3D(lengths=[2 * half], radii=[radius])


def _box(model: mujoco.MjModel, geom: int) -> Any:
    return rr.Boxes3D(half_sizes=[model.geom_size[geom]])


def _mesh(model: mujoco.MjModel, geom: int) -> Any:
    mesh = model.geom_dataid[geom]
    vertices = _part(model.mesh_vert, model.mesh_vertadr[mesh], model.mesh_vertnum[mesh])
    normals = _part(model.mesh_normal, model.mesh_normaladr[mesh], model.mesh_normalnum[mesh])
    faces = _part(model.mesh_face, model.mesh_faceadr[mesh], model.mesh_facenum[mesh])
    face_normals = _part(model.mesh_facenormal, model.mesh_faceadr[mesh], model.mesh_facenum[mesh])
    if len(normals) == len(vertices) and np.array_equal(faces, face_normals):
        return rr.Mesh3D(
            vertex_positions=vertices,
            triangle_indices=faces,
            vertex_normals=normals,
            albedo_factor=_color(model, geom),
        )
    return rr.Mesh3D(  # corners with normals of their own cannot be shared between faces
        vertex_positions=vertices[faces].reshape(-1, 3),
        vertex_normals=normals[face_normals].reshape(-1, 3),
        albedo_factor=_color(model, geom),
    )


def _part(values: Array, start: int, count: int) -> Array:
    return values[start : start + count]


def _height_field(model: mujoco.MjModel, geom: int) -> Any:
    field = model.geom_dataid[geom]
    rows, columns, start = model.hfield_nrow[field], model.hfield_ncol[field], model.hfield_adr[field]
    size_x, size_y, size_z, _ = model.hfield_size[field]
    z = model.hfield_data[start : start + rows * columns].reshape(rows, columns) * size_z
    x, y = np.meshgrid(np.linspace(-size_x, size_x, columns), np.linspace(-size_y, size_y, rows))
    index = np.arange(rows * columns).reshape(rows, columns)
    corners = np.stack([index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]], -1).reshape(-1, 4)
    return rr.Mesh3D(
        vertex_positions=np.stack([x, y, z], -1).reshape(-1, 3),
        triangle_indices=np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]),
        albedo_factor=_color(model, geom),
    )


def _floor(model: mujoco.MjModel, geom: int) -> Any:
    half_x, half_y = (max(float(half), _FLOOR_HALF_SIZE) for half in model.geom_size[geom][:2])
    x, y = (np.arange(-round(half / _TILE), round(half / _TILE)) * _TILE for half in (half_x, half_y))
    grid_x, grid_y = (grid.reshape(-1, 1) for grid in np.meshgrid(x, y, indexing="ij"))
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) * _TILE
    vertices = np.stack([grid_x + corners[:, 0], grid_y + corners[:, 1], np.zeros((len(grid_x), 4))], -1)
    odd = (np.round(grid_x / _TILE) + np.round(grid_y / _TILE)).astype(int)[:, 0] % 2
    first = np.arange(len(grid_x))[:, None] * 4
    halves = (np.array([0, 1, 2]), np.array([0, 2, 3]))
    return rr.Mesh3D(
        vertex_positions=vertices.reshape(-1, 3),
        triangle_indices=np.concatenate([first + half for half in halves]),
        vertex_colors=np.repeat(np.array(_FLOOR_COLORS, dtype=np.uint8)[odd], 4, axis=0),
        vertex_normals=np.tile([0.0, 0.0, 1.0], (vertices.shape[0] * 4, 1)),
    )


_SHAPES: dict[int, Callable[[mujoco.MjModel, int], Any]] = {
    int(mujoco.mjtGeom.mjGEOM_PLANE): _floor,
    int(mujoco.mjtGeom.mjGEOM_HFIELD): _height_field,
    int(mujoco.mjtGeom.mjGEOM_SPHERE): _sphere,
    int(mujoco.mjtGeom.mjGEOM_CAPSULE): _capsule,
    int(mujoco.mjtGeom.mjGEOM_ELLIPSOID): _ellipsoid,
    int(mujoco.mjtGeom.mjGEOM_CYLINDER): _cylinder,
    int(mujoco.mjtGeom.mjGEOM_BOX): _box,
    int(mujoco.mjtGeom.mjGEOM_MESH): _mesh,
}
