"""Kinematics of one configuration, from MuJoCo itself."""

from __future__ import annotations

import mujoco

from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import RobotModel


class Pose:
    """Kinematics of one configuration."""

    def __init__(self, robot: RobotModel, qpos: Array) -> None:
        self.robot, self.data = robot, mujoco.MjData(robot.model)
        self.data.qpos[:] = qpos
        mujoco.mj_kinematics(robot.model, self.data)
        mujoco.mj_comPos(robot.model, self.data)

    @property
    def com(self) -> Array:
        return self.data.subtree_com[1].copy()

    def site(self, name: str) -> Array:
        return self.data.site(name).xpos.copy()

    def rotation(self, name: str) -> Array:
        return self.data.site(name).xmat.reshape(3, 3).copy()
