"""Rendering what the head camera sees, with MuJoCo."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass

import mujoco
import numpy as np
from PIL import Image

from humanoid_bt.core.messages import Array

_NEAR = 0.02  # m; nearer things are cut away
_NO_GROUP = 5  # geoms of this group are not drawn
_SLICES, _STACKS = 16, 10  # of round shapes: enough for a small picture
_QUALITY = 80  # of JPEG


@dataclass(frozen=True)
class Setup:
    """What is told once.

    Attributes:
        model: the whole scene; the robot's qpos comes first.
        head: body that carries the camera, and is not seen by it.
        size: width and height of a picture [pixels].
        vertical_view: angle of view from top to bottom [rad].
    """

    model: mujoco.MjModel
    head: str
    size: tuple[int, int]
    vertical_view: float


@dataclass(frozen=True)
class Shot:
    """How things stand in one picture, world frame.

    Attributes:
        time: engine time [s].
        qpos: the robot's, shape (7 + nj,).
        position: of the camera, shape (3,) [m].
        direction: in which it looks, shape (3,).
        objects: body -> position, shape (3,) [m].
        hidden: bodies that are not to be seen.
    """

    time: float
    qpos: Array
    position: Array
    direction: Array
    objects: dict[str, Array]
    hidden: tuple[str, ...]


def first_shot() -> Shot:
    """Return a picture of how things stand in the model."""
    return Shot(0.0, np.zeros(0), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), {}, ())


class Camera:
    """Takes pictures.

    Raises:
        Exception: of any kind, where there is no OpenGL.
    """

    def __init__(self, setup: Setup) -> None:
        model = self._model = setup.model
        self._data = mujoco.MjData(model)
        self._groups = model.geom_group.copy()
        self._groups[model.geom_bodyid == model.body(setup.head).id] = _NO_GROUP
        quality = model.vis.quality
        quality.offsamples, quality.shadowsize, quality.numslices, quality.numstacks = 0, 0, _SLICES, _STACKS
        model.vis.map.znear = _NEAR / model.stat.extent
        model.vis.global_.fovy = math.degrees(setup.vertical_view)
        width, height = setup.size
        self._renderer = mujoco.Renderer(model, height, width)
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            self._renderer.scene.flags[flag] = False
        self._eye = mujoco.MjvCamera()
        self._eye.distance = 1.0

    def take(self, shot: Shot) -> bytes:
        """Return a picture as JPEG."""
        model, data, eye = self._model, self._data, self._eye
        model.geom_group[:] = self._groups
        for name, position in shot.objects.items():
            model.body(name).pos[:] = position
        for name in shot.hidden:
            model.geom_group[model.geom_bodyid == model.body(name).id] = _NO_GROUP
        data.qpos[: len(shot.qpos)] = shot.qpos
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_camlight(model, data)
        x, y, z = shot.direction
        eye.lookat[:] = shot.position + shot.direction
        eye.azimuth, eye.elevation = math.degrees(math.atan2(y, x)), math.degrees(math.atan2(z, math.hypot(x, y)))
        self._renderer.update_scene(data, eye)
        file = io.BytesIO()
        Image.fromarray(self._renderer.render()).save(file, "JPEG", quality=_QUALITY)
        return file.getvalue()
