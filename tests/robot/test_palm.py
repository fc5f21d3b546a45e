"""The frame of a palm: what robot.yaml says of it, and what is taken from the palm's place."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Side
from humanoid_bt.robot.arms import arms_of
from humanoid_bt.robot.config import RobotConfig, load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.robot.palm import palm_axes

FILE = Path(__file__).resolve().parents[2] / "sim" / "humanoid" / "robot.yaml"


def with_hand(side: Side, **values: Any) -> RobotConfig:
    config = load_robot_config(FILE)
    hand = dataclasses.replace(config.hands[side], **values)
    return dataclasses.replace(config, hands={**config.hands, side: hand})


@pytest.mark.parametrize(("side", "inward"), [("left", -1), ("right", 1)])
def test_the_built_in_robots_fingers_point_down_its_arm_and_its_palms_face_its_thighs(side: Side, inward: int) -> None:
    axes = palm_axes(load_robot_config(FILE), side)
    np.testing.assert_allclose(axes[:, 0], [0, 0, -1])
    np.testing.assert_allclose(axes[:, 2], [0, inward, 0])
    np.testing.assert_allclose(axes.T @ axes, np.eye(3), atol=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1)


def test_what_is_said_counts_and_the_palm_is_made_to_face_across_the_fingers() -> None:
    axes = palm_axes(with_hand("left", fingers=(2, 0, 0), facing=(0.5, 0, -1)), "left")
    np.testing.assert_allclose(axes, np.column_stack([[1, 0, 0], [0, -1, 0], [0, 0, -1]]), atol=1e-12)


def test_a_palm_whose_fingers_point_to_the_side_faces_down() -> None:
    axes = palm_axes(with_hand("left", position=(0, 0.1, 0)), "left")
    np.testing.assert_allclose(axes[:, [0, 2]], np.column_stack([[0, 1, 0], [0, 0, -1]]), atol=1e-12)


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"fingers": (0, 0, 0)}, "'fingers' is no direction"),
        ({"fingers": (1, 0, 0), "facing": (-1, 0, 0.1)}, "the left palm faces where its fingers point"),
    ],
)
def test_axes_that_are_none_are_refused_with_their_place(values: dict[str, Any], why: str) -> None:
    with pytest.raises(UserError, match=why) as caught:
        palm_axes(with_hand("left", **values), "left")
    assert "robot.yaml:" in str(caught.value)


def test_an_arm_has_the_joints_from_the_shoulder_to_the_hand() -> None:
    arms = arms_of(RobotModel(load_robot_config(FILE)))
    assert list(arms) == ["left", "right"]
    assert next(iter(arms["right"])) == "right_shoulder_pitch"
    assert list(arms["right"])[-1] == "right_wrist_roll"
    assert len(arms["right"]) == 7
    assert arms["right"]["right_elbow"] == pytest.approx((-2.28, -0.02))
