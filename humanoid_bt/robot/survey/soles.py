"""Where the sole of a foot is and how it is turned in its body, which many models turn as their CAD did."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array
from humanoid_bt.robot.footprint import footprint_in
from humanoid_bt.robot.survey.limbs import Surveyor

_STEEP = 0.7  # cosine between a sole's normal and the vertical, in the reference posture, at the least
_LARGER = 1.3  # times as large as what touches the floor as the foot is, a face must be to be taken for the sole
_FACES = 20  # of a mesh, the largest ones
_ALIKE = 0.999  # cosine of the normals of one face
ALIGNED = 0.05  # rad up to which the axes of a body count as those of what it carries


def sole_axes(surveyor: Surveyor, foot: int) -> Array:
    """Return what is ahead, left and up of a sole, in the frame of its body, shape (3, 3).

    The sole is the face of the foot, among those that look down at least a little in the reference posture, that
    touches most of a floor: most often what does so in that posture. Ahead is where the base looks then.

    Args:
        surveyor: of the model.
        foot: the body.
    """
    model, data = surveyor.model, surveyor.data
    base, turn = data.xmat[surveyor.base].reshape(3, 3), data.xmat[foot].reshape(3, 3)
    upright = _axes(turn.T @ base[:, 2], turn.T @ base[:, 0])
    best, most = upright, _area(model, data, foot, upright) * _LARGER
    for normal in _normals(surveyor, foot):
        if -normal @ base[:, 2] > _STEEP:
            axes = _axes(-turn.T @ normal, turn.T @ base[:, 0])
            if (area := _area(model, data, foot, axes)) > most:
                best, most = axes, area
    return np.eye(3) if angle_of(best) < ALIGNED else best


def angle_of(rotation: Array) -> float:
    """Return how far a rotation turns [rad]."""
    return float(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1.0, 1.0)))


def _axes(up: Array, ahead: Array) -> Array:
    ahead = ahead - (ahead @ up) * up
    ahead = ahead / np.linalg.norm(ahead)
    return np.column_stack([ahead, np.cross(up, ahead), up])


def _area(model: mujoco.MjModel, data: mujoco.MjData, foot: int, axes: Array) -> float:
    """Return how much of the floor a foot touches that stands on it like this [m^2]."""
    found = footprint_in(model, data, foot, axes)
    return float(np.prod(found.half)) if found else 0.0


def _normals(surveyor: Surveyor, foot: int) -> Iterator[Array]:
    """Yield which way the flat faces of a foot look, world frame, shape (3,)."""
    model, data, types = surveyor.model, surveyor.data, mujoco.mjtGeom
    for geom in surveyor.geoms(foot):
        kind, turn = int(model.geom_type[geom]), data.geom_xmat[geom].reshape(3, 3)
        if not (model.geom_contype[geom] or model.geom_conaffinity[geom]):
            continue
        if kind == types.mjGEOM_BOX:
            yield from (*turn.T, *-turn.T)
        elif kind == types.mjGEOM_CYLINDER:
            yield from (turn[:, 2], -turn[:, 2])
        elif kind == types.mjGEOM_MESH:
            yield from _faces(model, int(model.geom_dataid[geom])) @ turn.T


def _faces(model: mujoco.MjModel, mesh: int) -> Array:
    """Return the normals of the largest faces of a mesh, in its frame, shape (n, 3)."""
    first, number = int(model.mesh_vertadr[mesh]), int(model.mesh_facenum[mesh])
    corners = model.mesh_face[model.mesh_faceadr[mesh] :][:number]
    a, b, c = (model.mesh_vert[first + corners[:, i]].astype(float) for i in range(3))
    across = np.cross(b - a, c - a)
    sizes = np.linalg.norm(across, axis=1)
    order = [i for i in np.argsort(-sizes).tolist() if sizes[i] > 0]
    found: list[Array] = []
    for i in order:
        normal = across[i] / sizes[i]
        if len(found) < _FACES and all(float(normal @ other) < _ALIKE for other in found):
            found.append(normal)
    return np.array(found).reshape(-1, 3)
