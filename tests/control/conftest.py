from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.messages import Array, Estimate
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from tests.control.control_rig import ControlRig
from tests.joint_ranges import write_joint_ranges
from tests.line_feet import write_line_feet
from tests.other_frames import write_other_frames

ROBOT = Path(__file__).resolve().parents[2] / "sim" / "humanoid" / "robot.yaml"


@pytest.fixture(scope="session")
def robot() -> RobotModel:
    return RobotModel(load_robot_config(ROBOT))


@pytest.fixture(scope="session")
def line_feet(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    """A robot whose feet no joint rolls."""
    return RobotModel(load_robot_config(write_line_feet(tmp_path_factory.mktemp("line_feet"))))


@pytest.fixture(scope="session")
def endless(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    """A robot whose arms, waist and neck turn on and on."""
    folder = tmp_path_factory.mktemp("endless")
    joints = ("*_shoulder_*", "*_elbow", "*_wrist_*", "waist_*", "neck_*")
    return RobotModel(load_robot_config(write_joint_ranges(folder, *joints)))


@pytest.fixture(scope="session")
def other_frames(tmp_path_factory: pytest.TempPathFactory) -> RobotModel:
    """The robot with other frames and axes; it moves the same."""
    return RobotModel(load_robot_config(write_other_frames(tmp_path_factory.mktemp("other_frames"))))


@pytest.fixture(scope="session")
def standing(robot: RobotModel) -> Array:
    """The configuration in which the robot starts, shape (7 + nj,)."""
    posture = standing_posture(robot)
    posture.setflags(write=False)
    return posture


@pytest.fixture(scope="session")
def shared_rig(robot: RobotModel, standing: Array) -> ControlRig:
    return ControlRig(robot, standing)


@pytest.fixture
def rig(shared_rig: ControlRig) -> ControlRig:
    """A robot that stands at the origin at time 0."""
    shared_rig.reset()
    return shared_rig


@pytest.fixture
def estimate(robot: RobotModel, standing: Array) -> Estimate:
    """What control would believe of the standing robot if it knew everything."""
    joints = len(robot.joint_names)
    return Estimate(0.0, standing, np.zeros(6 + joints), np.zeros(joints), np.full(2, robot.mass * GRAVITY / 2))
