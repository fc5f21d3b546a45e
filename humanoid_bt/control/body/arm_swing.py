"""The arms that swing with the legs: each goes ahead with the foot of the other side, as a person's do."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping

import numpy as np

from humanoid_bt.control.jacobians import Indices
from humanoid_bt.core.compiled import compiled
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
        pitches = [[joint for joint in robot.arm_joints(side) if abs(across[joint]) > _ALONG] for side in SIDES]
        self._shoulders = np.array([pitch[0] if pitch else -1 for pitch in pitches])
        self._signs = np.sign(across[self._shoulders])  # which way each of them turns
        self.joints: Array = np.zeros(len(across))

    def update(self, stance: Array, feet: Mapping[Side, Array], busy: Collection[Side]) -> None:
        """Swing the arms that have nothing else to do.

        Args:
            stance, feet: poses of the middle between the feet and of the feet, shape (3,), world frame.
            busy: sides whose hands are commanded.
        """
        _swing(
            self.joints, stance, feet["left"], feet["right"], "left" in busy, "right" in busy,
            self._shoulders, self._signs, self._gain, self._share,
        )  # fmt: skip


@compiled("void(f8[::1], f8[::1], f8[::1], f8[::1], b1, b1, i8[::1], f8[::1], f8, f8)")
def _swing(
    joints: Array,
    stance: Array,
    left: Array,
    right: Array,
    left_busy: bool,
    right_busy: bool,
    shoulders: Indices,
    signs: Array,
    gain: float,
    share: float,
) -> None:
    """See :meth:`ArmSwing.update`.

    Args:
        joints: how far they are from the posture, shape (nj,) [rad]; is changed.
        stance, left, right: poses of the middle between the feet and of the feet, shape (3,).
        left_busy, right_busy: whether each hand is commanded.
        shoulders, signs: the joint that swings each arm, -1 for none, and 1, or -1 if it turns the other way round.
        gain: [rad/m].
        share: of the way in this control period.
    """
    cos, sin = math.cos(stance[2]), math.sin(stance[2])
    for side in range(2):
        foot, busy, joint = (left, left_busy, shoulders[0]) if side == 0 else (right, right_busy, shoulders[1])
        if joint >= 0:
            ahead = 2 * (cos * (foot[0] - stance[0]) + sin * (foot[1] - stance[1]))  # of the other foot [m]
            wanted = 0.0 if busy else signs[side] * min(max(gain * ahead, -_FARTHEST), _FARTHEST)
            joints[joint] += share * (wanted - joints[joint])
