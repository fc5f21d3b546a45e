from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel, sole_site
from tests.control.body.pose import Pose


def test_the_standing_posture_puts_both_feet_flat_beside_each_other(robot: RobotModel, standing: Array) -> None:
    pose = Pose(robot, standing)
    half = robot.config.gait.stance_width / 2
    for side, sign in (("left", 1), ("right", -1)):
        np.testing.assert_allclose(pose.site(sole_site(side)), [0, sign * half, 0], atol=2e-4)
        np.testing.assert_allclose(pose.rotation(sole_site(side)), np.eye(3), atol=1e-3)


def test_the_standing_posture_has_the_weight_over_the_middle_of_the_feet(robot: RobotModel, standing: Array) -> None:
    np.testing.assert_allclose(Pose(robot, standing).com[:2], [0, 0], atol=1e-3)


def test_the_standing_posture_is_symmetric_upright_and_inside_the_soft_limits(
    robot: RobotModel, standing: Array
) -> None:
    joints = dict(zip(robot.joint_names, standing[BASE_COORDINATES:], strict=True))
    for name, angle in joints.items():
        if name.startswith("left_"):
            mirrored = joints[name.replace("left_", "right_")]
            turns_with_the_side = name.endswith(("_yaw", "_roll"))
            assert angle == pytest.approx(-mirrored if turns_with_the_side else mirrored, abs=2e-3), name
    np.testing.assert_allclose(standing[3:7], [1, 0, 0, 0], atol=1e-2)
    inside = (standing[BASE_COORDINATES:] >= robot.lower - 1e-6) & (standing[BASE_COORDINATES:] <= robot.upper + 1e-6)
    assert inside.all()


def test_a_robot_that_cannot_stand_is_answered_with_the_place_of_its_home_posture(robot: RobotModel) -> None:
    config = replace(robot.config, gait=replace(robot.config.gait, stance_width=1.5))
    with pytest.raises(UserError, match="humanoid cannot stand with flat feet") as error:
        standing_posture(RobotModel(config))
    assert error.value.problems[0].place == config.place("home")
