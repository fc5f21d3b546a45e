"""What robot.yaml says of what a robot can do."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import pytest

from humanoid_bt.core.messages import RESOURCES
from humanoid_bt.robot.config import RobotConfig, load_robot_config

FILE = Path(__file__).resolve().parents[2] / "sim" / "humanoid" / "robot.yaml"


@pytest.fixture(scope="module")
def config() -> RobotConfig:
    return load_robot_config(FILE)


def test_the_built_in_robot_has_every_resource(config: RobotConfig) -> None:
    assert config.resources == RESOURCES


def test_a_robot_without_hands_has_no_resource_for_them(config: RobotConfig) -> None:
    assert dataclasses.replace(config, hands={}).resources == ("base", "gaze", "posture")


def test_a_robot_looks_with_its_neck_or_else_with_its_torso(config: RobotConfig) -> None:
    neckless = dataclasses.replace(config, neck=None)
    assert "gaze" in neckless.resources
    stiff = dataclasses.replace(neckless, torso=config.base)
    assert stiff.resources == ("base", "left_hand", "right_hand", "posture")
