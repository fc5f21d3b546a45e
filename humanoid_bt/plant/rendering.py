"""Rendering what the head camera sees, with MuJoCo."""

from __future__ import annotations

import io
import math
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np
from PIL import Image

from humanoid_bt.core.messages import Array

_NEAR = 0.02  # m; nearer things are cut away
_NO_GROUP = 5  # geoms of this group are not drawn
_SLICES, _STACKS = 16, 10  # of round shapes: enough for a small picture
_SHADOWS = 256  # pixels of a shadow map that is never drawn, but made
_MOST_GEOMS = 10_000
_QUALITY = 80  # of JPEG
_WIDTH = 320  # pixels
_WIDEST = 2.4  # rad; a flat picture of a wider angle is all edges
_NARROWEST = 0.1  # share of the picture's longer side that the shorter one has at least


@dataclass(frozen=True)
class View:
    """What a camera has in the picture: all of two angles, and more of one that is very narrow beside the other.

    Attributes:
        body: that carries it, and is not in the picture; "" for none.
        horizontal, vertical: full angles [rad].
    """

    body: str
    horizontal: float
    vertical: float

    @property
    def angle(self) -> float:
        """Angle from the top to the bottom of the picture [rad]."""
        return 2 * math.atan(self._halves[1])

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the picture [pixels]."""
        across, up = self._halves
        return _WIDTH, round(_WIDTH * up / across)

    @property
    def focal(self) -> float:
        """Focal length [pixels]."""
        return self.size[1] / 2 / math.tan(self.angle / 2)

    @property
    def _halves(self) -> tuple[float, float]:
        """Tangents of half the angles that are in the picture, horizontal and vertical."""
        across, up = (math.tan(min(angle, _WIDEST) / 2) for angle in (self.horizontal, self.vertical))
        return max(across, _NARROWEST * up), max(up, _NARROWEST * across)


@dataclass(frozen=True)
class Setup:
    """What is told once.

    Attributes:
        model: the whole scene; the robot's qpos comes first.
        view: what is in a picture.
        depth: whether pictures have a depth, and are arrays; else they are JPEG.
    """

    model: mujoco.MjModel
    view: View
    depth: bool = False


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
        up: what is up in the picture, shape (3,), at right angles to the direction; None for a level camera.
    """

    time: float
    qpos: Array
    position: Array
    direction: Array
    objects: dict[str, Array]
    hidden: tuple[str, ...]
    up: Array | None = None


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
        self._jpeg = not setup.depth
        self._data = mujoco.MjData(model)
        self._groups = model.geom_group.copy()
        if setup.view.body:
            self._groups[model.geom_bodyid == model.body(setup.view.body).id] = _NO_GROUP
        quality, shown = model.vis.quality, model.vis.global_
        quality.offsamples, quality.shadowsize, quality.numslices, quality.numstacks = 0, _SHADOWS, _SLICES, _STACKS
        model.vis.map.znear = _NEAR / model.stat.extent
        shown.fovy = math.degrees(setup.view.angle)
        width, height = shown.offwidth, shown.offheight = setup.view.size
        self._opengl = mujoco.GLContext(width, height)
        self._opengl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        # the other way round, depth is kept in floats that are finest near the camera, and nothing far from it
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR
        self._scene = mujoco.MjvScene(model, _MOST_GEOMS)
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            self._scene.flags[flag] = False
        self._options, self._eye = mujoco.MjvOption(), mujoco.MjvCamera()
        self._eye.distance = 1.0
        self._picture = mujoco.MjrRect(0, 0, width, height)
        self._color = np.empty((height, width, 3), dtype=np.uint8)
        self._depth = np.empty((height, width), dtype=np.float32)

    def take(self, shot: Shot) -> Any:
        """Return a picture as JPEG; with depth its colours, shape (height, width, 3), and depths [m], inf for none."""
        self._place(shot)
        mujoco.mjr_render(self._picture, self._scene, self._context)
        if self._jpeg:
            mujoco.mjr_readPixels(self._color, None, self._picture, self._context)
            file = io.BytesIO()
            Image.fromarray(self._color[::-1]).save(file, "JPEG", quality=_QUALITY)
            return file.getvalue()
        mujoco.mjr_readPixels(self._color, self._depth, self._picture, self._context)
        return self._color[::-1].copy(), self._metres(self._depth[::-1])

    def _place(self, shot: Shot) -> None:
        """Have everything stand as it does in a shot."""
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
        everything = mujoco.mjtCatBit.mjCAT_ALL
        mujoco.mjv_updateScene(model, data, self._options, None, eye, everything, self._scene)
        if shot.up is not None:
            for one in self._scene.camera:  # of the left and the right eye, which are one here
                one.pos[:], one.forward[:], one.up[:] = shot.position, shot.direction, shot.up

    def _metres(self, read: Any) -> Any:
        """Return depths [m] of what was read: 1 at the near plane, 0 at the far one, hyperbolic between them."""
        visible, extent = self._model.vis.map, self._model.stat.extent
        near, far = visible.znear * extent, visible.zfar * extent
        metres = (near * far / (read.astype(np.float64) * (far - near) + near)).astype(np.float32)
        metres[read <= 0] = np.inf
        return metres
