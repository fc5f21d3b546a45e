"""The head camera as percept sources see with it: rendered where the eyes really are, placed where control believes."""

from __future__ import annotations

import mujoco
import numpy as np

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array, State, Truth
from humanoid_bt.perception.picture import Picture
from humanoid_bt.plant.camera_client import CameraLost, CameraProcess
from humanoid_bt.plant.opengl import INSTALL
from humanoid_bt.plant.rendering import Setup, Shot, View
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import widest_view
from humanoid_bt.plant.scene_model import scene_model
from humanoid_bt.robot.model import BASE_COORDINATES, GAZE_SITE, RobotModel

_TIMEOUT = 10.0  # s on the wall clock until a picture must be there; software takes 0.03 s for one


class Eyes:
    """A camera in the head of a robot in a scene.

    Args:
        robot: the robot.
        scene: what surrounds it.

    Attributes:
        why_none: why there are no pictures, "" as long as there may be some.
    """

    def __init__(self, robot: RobotModel, scene: Scene) -> None:
        self._scene = scene
        model = scene_model(robot, scene)
        self._view = View(robot.config.gaze.body, *widest_view(scene.config))
        self._camera = CameraProcess(Setup(model, self._view, depth=True), np.inf, _TIMEOUT)
        self._model, self._data = model, mujoco.MjData(model)  # for kinematics only
        self._site = model.site(GAZE_SITE).id
        self._joints = len(robot.joint_names)
        self.why_none = "the camera is not open"

    def open(self) -> None:
        """Start the camera.

        Raises:
            UserError: there are no pictures.
        """
        self.why_none = self._camera.open()
        if self.why_none:
            self._camera.end()
            message = f"a percept source needs the head camera, and there is no picture: {self.why_none}"
            raise UserError(message, hint=INSTALL)

    def look(self, robot: Truth, state: State) -> Picture | None:
        """Return what the camera sees, None if there are no pictures any more.

        Args:
            robot: where the robot really is, its joints too: from there the picture is taken.
            state: what control believes at that time: from it comes where the picture is said to be taken from.
        """
        if self.why_none:
            return None
        position, axes = self._eye(robot.base_position, robot.base_quaternion, robot.joint_positions)
        scene, names = self._scene, self._scene.config.objects
        shot = Shot(
            robot.time,
            np.concatenate([robot.base_position, robot.base_quaternion, robot.joint_positions]),
            position,
            axes[:, 0],
            {f"object_{name}": scene.object_position(name, robot.time) for name in names},
            tuple(f"object_{name}" for name in names if scene.hidden(name, robot.time)),
            axes[:, 2],
        )
        try:
            color, depth = self._camera.take(shot)
        except CameraLost as error:
            self.why_none = str(error)
            self._camera.end()
            return None
        believed, turn = self._eye(state.base_position, state.base_quaternion, state.joint_positions)
        base = rotation_matrix(state.base_quaternion)
        for array in (color, depth):
            array.setflags(write=False)
        return Picture(color, depth, self._view.focal, base.T @ (believed - state.base_position), base.T @ turn)

    def close(self) -> None:
        """End the camera."""
        self._camera.end()

    def _eye(self, position: Array, quaternion: Array, joints: Array) -> tuple[Array, Array]:
        """Return where the eye of a robot that stands so is, shape (3,), and its frame in the world, shape (3, 3)."""
        data = self._data
        data.qpos[:3], data.qpos[3:7] = position, quaternion
        data.qpos[BASE_COORDINATES : BASE_COORDINATES + self._joints] = joints
        mujoco.mj_kinematics(self._model, data)
        return data.site_xpos[self._site].copy(), data.site_xmat[self._site].reshape(3, 3).copy()
