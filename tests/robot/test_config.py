"""What robot.yaml says of what a robot can do."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import RESOURCES, SIDES
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


@pytest.mark.parametrize("side", SIDES)
def test_one_leg_alone_cannot_lack_an_ankle_roll(side: str, tmp_path: Path) -> None:
    file = _copied(tmp_path, f"    ankle_roll: {side}_ankle_roll\n")
    with pytest.raises(UserError) as raised:
        load_robot_config(file)
    (problem,) = raised.value.problems
    other = "right" if side == "left" else "left"
    assert problem.message == f"only the {other} leg has an 'ankle_roll'"


def test_a_foot_that_no_joint_rolls_bears_along_its_middle_line(config: RobotConfig, tmp_path: Path) -> None:
    sole = config.sole
    assert sole.bears == (sole.half_length - sole.margin, sole.half_width - sole.margin)
    rolls = [f"    ankle_roll: {side}_ankle_roll\n" for side in SIDES]
    file = _copied(tmp_path, *rolls)
    without = load_robot_config(file)
    assert not without.feet_roll
    assert without.sole.bears == (sole.half_length - sole.margin, 0.0)
    file.write_text(file.read_text().replace("half_width: 0.045", "half_width: 0.045, side_margin: 0.04"))
    assert load_robot_config(file).sole.bears[1] == pytest.approx(0.005)


@pytest.mark.parametrize("name", ["s", '""', "legs"])
def test_a_group_may_have_any_name(name: str, tmp_path: Path) -> None:
    file = _copied(tmp_path)
    file.write_text(file.read_text().replace("  left_leg: [", f"  {name}: ["))
    assert load_robot_config(file).group("left_knee") == name.strip('"')


def test_a_step_shorter_than_control_can_make_one_is_refused(tmp_path: Path) -> None:
    file = _copied(tmp_path)
    file.write_text(file.read_text().replace("single_support: 0.28", "single_support: 4 ms"))
    with pytest.raises(UserError, match="single_support"):
        load_robot_config(file)


def _copied(folder: Path, *without: str) -> Path:
    """Return a copy of the built-in robot's file without some lines, beside a copy of its model."""
    text = FILE.read_text()
    for line in without:
        assert line in text
        text = text.replace(line, "")
    shutil.copy(FILE.with_name("humanoid.xml"), folder)
    (folder / "robot.yaml").write_text(text)
    return folder / "robot.yaml"
