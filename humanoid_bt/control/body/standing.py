"""Loading a robot, ready to stand."""

from __future__ import annotations

import functools
from pathlib import Path

from humanoid_bt.control.body.inverse_kinematics import standing_posture
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel


@functools.lru_cache(maxsize=4)
def load_robot(path: Path) -> tuple[RobotModel, Array]:
    """Return a robot and the configuration it starts in, shape (7 + nj,).

    Args:
        path: its ``robot.yaml``.

    Raises:
        UserError: ``robot.yaml`` or the model is not valid.
    """
    robot = RobotModel(load_robot_config(path))
    return robot, standing_posture(robot)
