"""The arms that swing with the legs: each goes ahead with the foot of the other side, as a person's do."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import RobotModel

_ALONG = 0.8  # of a joint's axis along the robot's, for the joint to swing the arm ahead and back
_FARTHEST = 0.4  # rad
_TIME = 0.1  # s, low-pass


class ArmSwing:
    """How far the joints of the arms are from the posture because the robot walks.

    Args:
        robot: the robot.
        dt: control period [s].

    Attributes:
        joints: shape (nj,) [rad].
    """

    def __init__(self, robot: RobotModel, dt: float) -> None:
        self._share, self._gain = min(1.0, dt / _TIME), robot.config.gait.arm_swing
        across = robot.axes[:, 1]
        self._shoulders: dict[Side, tuple[int, float]] = {}  # joint, and which way it turns
        for side in SIDES:
            pitch = [joint for joint in robot.arm_joints(side) if abs(across[joint]) > _ALONG]
            if pitch:
                self._shoulders[side] = pitch[0], float(np.sign(across[pitch[0]]))
        self.joints: Array = np.zeros(len(across))

    def update(self, stance: Array, feet: Mapping[Side, Array], busy: Collection[Side]) -> None:
        """Swing the arms that have nothing else to do.

        Args:
            stance, feet: poses of the middle between the feet and of the feet, shape (3,), world frame.
            busy: sides whose hands are commanded.
        """
        at_x, at_y, heading = stance.tolist()
        cos, sin = math.cos(heading), math.sin(heading)
        for side, (joint, sign) in self._shoulders.items():
            x, y, _ = feet[side].tolist()
            ahead = 2 * (cos * (x - at_x) + sin * (y - at_y))  # of the other foot [m]
            wanted = 0.0 if side in busy else sign * min(max(self._gain * ahead, -_FARTHEST), _FARTHEST)
            now = self.joints.item(joint)
            self.joints[joint] = now + self._share * (wanted - now)
