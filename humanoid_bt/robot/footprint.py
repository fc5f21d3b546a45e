"""Where the foot of a model touches the ground: what the sole of ``robot.yaml`` must say."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.model import RobotModel, axes_of

_FLAT = 0.005  # m above its lowest point up to which a foot counts as its sole
_AROUND = np.linspace(0, 2 * np.pi, 16, endpoint=False)


@dataclass(frozen=True)
class Footprint:
    """The rectangle around the points of a foot that touch a flat floor.

    Attributes:
        centre: in the foot's frame, shape (3,) [m].
        half: half length and half width, along the axes of the sole, shape (2,) [m].
    """

    centre: Array
    half: Array


def footprint(robot: RobotModel, side: Side) -> Footprint | None:
    """Return what of a foot touches the floor in the home posture, as :func:`footprint_in` does."""
    model = robot.model
    data = mujoco.MjData(model)
    data.qpos[:] = robot.home_qpos
    mujoco.mj_kinematics(model, data)
    sole = robot.config.legs[side].sole
    return footprint_in(model, data, model.body(sole.body).id, axes_of(robot.config, sole, "legs", side, "sole"))


def footprint_in(model: mujoco.MjModel, data: mujoco.MjData, foot: int, axes: Array) -> Footprint | None:
    """Return what of a body, and of those fixed to it, touches a flat floor; None if nothing of it can touch.

    Args:
        model: of the robot.
        data: in the posture in which the foot is flat.
        foot: the body.
        axes: of the sole: ahead, left and up in the foot's frame, shape (3, 3).
    """
    parts = [
        _points(model, data, geom)
        for geom in range(model.ngeom)
        if model.body_weldid[model.geom_bodyid[geom]] == model.body_weldid[foot]
        and (model.geom_contype[geom] or model.geom_conaffinity[geom])
    ]
    if not parts:
        return None
    points = (np.concatenate(parts) - data.xpos[foot]) @ data.xmat[foot].reshape(3, 3) @ axes
    down = points[:, 2].min()
    touching = points[points[:, 2] < down + _FLAT, :2]
    low, high = touching.min(axis=0), touching.max(axis=0)
    return Footprint(axes @ [*(low + high) / 2, down], (high - low) / 2)


def _points(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Array:
    """Return points on a geom, among them the lowest ones of a flat one: shape (n, 3), world frame [m]."""
    kind, size = mujoco.mjtGeom(int(model.geom_type[geom])), model.geom_size[geom]
    types = mujoco.mjtGeom
    if kind == types.mjGEOM_MESH:
        first = model.mesh_vertadr[model.geom_dataid[geom]]
        local = model.mesh_vert[first : first + model.mesh_vertnum[model.geom_dataid[geom]]]
    elif kind == types.mjGEOM_CYLINDER:
        circle = np.stack([size[0] * np.cos(_AROUND), size[0] * np.sin(_AROUND), np.full(_AROUND.shape, size[1])], 1)
        local = np.concatenate([circle, circle * [1, 1, -1]])
    elif kind == types.mjGEOM_BOX:
        local = size * np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    elif kind == types.mjGEOM_CAPSULE:
        local = np.array([[0, 0, size[1]], [0, 0, -size[1]]])
    else:
        local = np.zeros((1, 3))
    world = data.geom_xpos[geom] + local @ data.geom_xmat[geom].reshape(3, 3).T
    if kind in (types.mjGEOM_CAPSULE, types.mjGEOM_SPHERE):  # round: only the point below touches
        world = world - [0, 0, size[0]]
    elif kind == types.mjGEOM_ELLIPSOID:
        axes = data.geom_xmat[geom].reshape(3, 3) * size
        world = world - [0, 0, np.linalg.norm(axes[2])]
    return np.asarray(world)
