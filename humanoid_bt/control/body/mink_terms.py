"""The body in mink's terms: its model, tasks and poses."""

from __future__ import annotations

import mink
import mujoco
import numpy as np

from humanoid_bt.core.geometry import planar_pose
from humanoid_bt.robot.model import RobotModel

SOLVER = "daqp"


def within_soft_limits(robot: RobotModel) -> mujoco.MjModel:
    """Return a copy of the robot whose joint ranges are the soft limits, so that the solver keeps to them."""
    model = robot.spec().compile()
    limited = model.jnt_limited.astype(bool)
    limited[0] = False
    model.jnt_range[limited] = np.stack([robot.lower, robot.upper], axis=1)[limited[1:]]
    return model


def frame_task(name: str, kind: str, position: float, orientation: float, lm_damping: float = 0.0) -> mink.FrameTask:
    """Return a task for a body or a site, with its costs per metre and per radian."""
    return mink.FrameTask(name, kind, position_cost=position, orientation_cost=orientation, lm_damping=lm_damping)


def planar_se3(yaw: float, position: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> mink.SE3:
    """Return the pose at a position [m], upright, with a heading [rad], as mink has it."""
    pose = planar_pose(*position, yaw)
    return mink.SE3(np.concatenate([pose[3:], pose[:3]]))
