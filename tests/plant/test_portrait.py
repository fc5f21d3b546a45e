"""The picture of a robot, and how high it stands."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.plant.portrait import height, portrait

ROBOT = load_robot(Workspace(builtin_root()).find_robot("humanoid"))


def test_a_robot_is_as_high_as_its_head() -> None:
    robot, standing = ROBOT
    assert height(robot, standing) == pytest.approx(1.33, abs=0.02)
    raised = standing.copy()
    raised[7 + robot.joint("left_shoulder_pitch")] = -np.pi
    assert height(robot, raised) > 1.4, "a hand is above the head"


def test_the_whole_robot_is_in_the_picture_or_it_is_told_why_there_is_none() -> None:
    picture, why = portrait(*ROBOT)
    if why:
        assert (picture, "OpenGL" in why) == (b"", True)
        pytest.skip(why)
    pixels = np.asarray(Image.open(io.BytesIO(picture)), dtype=float)
    tall, wide, _ = pixels.shape
    assert tall > 1.3 * wide
    columns = np.abs(pixels - pixels[:, :1]).sum(axis=2) > 60  # what differs from the left edge of its line
    rows = np.flatnonzero(columns[:, wide // 3 : 2 * wide // 3].any(axis=1))
    assert rows[0] > 0.02 * tall and rows[-1] < 0.98 * tall
    assert np.ptp(rows) > 0.6 * tall


def test_without_opengl_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "disabled")
    picture, why = portrait(*ROBOT)
    assert picture == b""
    assert "there is no OpenGL to render with" in why
