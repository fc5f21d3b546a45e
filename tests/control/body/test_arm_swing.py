"""The arms swing with the legs."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.arm_swing import ArmSwing
from humanoid_bt.control.body.planar import ahead
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.model import RobotModel

DT = 0.005
STANCE = np.zeros(3)
LEFT_AHEAD: dict[Side, Array] = {"left": np.array([0.1, 0.09, 0.0]), "right": np.array([-0.1, -0.09, 0.0])}


@pytest.fixture
def swing(robot: RobotModel) -> ArmSwing:
    return ArmSwing(robot, DT)


def settle(
    swing: ArmSwing, busy: tuple[Side, ...] = (), stance: Array = STANCE, feet: dict[Side, Array] = LEFT_AHEAD
) -> Array:
    for _ in range(200):
        swing.update(stance, feet, busy)
    return swing.joints


def test_each_arm_goes_ahead_with_the_other_foot(swing: ArmSwing, robot: RobotModel) -> None:
    joints = settle(swing)
    moved = {robot.joint_names[joint]: joints[joint] for joint in np.flatnonzero(np.abs(joints) > 1e-6)}
    assert moved.keys() == {"left_shoulder_pitch", "right_shoulder_pitch"}
    assert moved["left_shoulder_pitch"] == pytest.approx(robot.config.gait.arm_swing * 0.2, rel=1e-3)  # back
    assert moved["right_shoulder_pitch"] == pytest.approx(-moved["left_shoulder_pitch"])


def test_which_joints_swing_does_not_depend_on_how_frames_are_turned(swing: ArmSwing, other_frames: RobotModel) -> None:
    np.testing.assert_array_equal(settle(ArmSwing(other_frames, DT)), settle(swing))


def test_which_way_an_arm_swings_does_not_depend_on_which_way_round_its_joint_turns(
    swing: ArmSwing, robot: RobotModel
) -> None:
    other: Any = SimpleNamespace(axes=-robot.axes, config=robot.config, arm_joints=robot.arm_joints)
    np.testing.assert_array_equal(settle(ArmSwing(other, DT)), -settle(swing))


def test_arms_swing_wherever_the_robot_walks(swing: ArmSwing, robot: RobotModel) -> None:
    stance = np.array([2.0, -1.0, 2.5])
    feet = {side: ahead(stance, *foot[:2].tolist()) for side, foot in LEFT_AHEAD.items()}
    np.testing.assert_allclose(settle(ArmSwing(robot, DT), (), stance, feet), settle(swing), atol=1e-9)


def test_arms_swing_no_farther_however_long_the_steps(swing: ArmSwing) -> None:
    far = {side: foot * [5.0, 1.0, 1.0] for side, foot in LEFT_AHEAD.items()}
    assert np.abs(settle(swing, feet=far)).max() == pytest.approx(0.4, rel=1e-3)


def test_an_arm_whose_hand_is_commanded_does_not_swing(swing: ArmSwing, robot: RobotModel) -> None:
    settle(swing)
    joints = settle(swing, busy=("left",))
    assert joints[robot.joint("left_shoulder_pitch")] == pytest.approx(0, abs=1e-3)
    assert joints[robot.joint("right_shoulder_pitch")] < -0.2


def test_it_never_jumps(swing: ArmSwing) -> None:
    before = swing.joints.copy()
    swing.update(STANCE, LEFT_AHEAD, ())
    assert np.abs(swing.joints - before).max() < 0.02
