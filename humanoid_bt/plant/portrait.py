"""A picture of a robot that stands, for people."""

from __future__ import annotations

import io
import math

import mujoco
import numpy as np
from PIL import Image

from humanoid_bt.core.messages import Array
from humanoid_bt.plant.camera_client import CameraLost, CameraProcess
from humanoid_bt.plant.rendering import Setup, Shot, View
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.plant.scene_model import scene_model
from humanoid_bt.robot.model import RobotModel

_HORIZONTAL, _VERTICAL = math.radians(24), math.radians(34)  # of the picture
_FROM = np.array([0.92, 0.34, 0.20])  # of the camera, seen from the robot: in front, a little to its left and above
_AROUND = 1.12  # of the robot's height, which is in the picture
_PATIENCE = 60.0  # s for a picture


def portrait(robot: RobotModel, qpos: Array) -> tuple[bytes, str]:
    """Return a picture as PNG, rendered without a display; b"" and why there is none where there is no OpenGL.

    Args:
        robot: the robot.
        qpos: how it stands, shape (7 + nj,).
    """
    model = scene_model(robot, Scene(SceneConfig(format=1, name="empty"), 0))
    camera = CameraProcess(Setup(model, View("", _HORIZONTAL, _VERTICAL), depth=True), math.inf, _PATIENCE)
    try:
        if why := camera.open():
            return b"", why
        tall = height(robot, qpos)
        away = _FROM / np.linalg.norm(_FROM)
        distance = tall * _AROUND / 2 / math.tan(_VERTICAL / 2)
        position = np.array([qpos[0], qpos[1], tall / 2]) + distance * away
        color, _ = camera.take(Shot(0.0, qpos, position, -away, {}, ()))
    except CameraLost as error:
        return b"", str(error)
    finally:
        camera.end()
    file = io.BytesIO()
    Image.fromarray(color).save(file, "PNG", optimize=True)
    return file.getvalue(), ""


def height(robot: RobotModel, qpos: Array) -> float:
    """Return how high the highest point of a robot is above the origin [m], as far as boxes around its geoms tell.

    Args:
        robot: the robot.
        qpos: how it stands, shape (7 + nj,).
    """
    model = robot.model
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(model, data)
    up = data.geom_xmat[:, 6:]
    centre, half = model.geom_aabb[:, :3], model.geom_aabb[:, 3:]
    return float((data.geom_xpos[:, 2] + (up * centre).sum(axis=1) + (np.abs(up) * half).sum(axis=1)).max())
