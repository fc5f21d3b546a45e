"""``humanoid-bt robots init``: a first robot.yaml for a model, or one clear message."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from humanoid_bt.checking.robot import robot_problems
from humanoid_bt.cli import main
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel

MODEL = builtin_root() / "sim" / "humanoid" / "humanoid.xml"


@pytest.fixture
def model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return Path(shutil.copy(MODEL, tmp_path / "walker.xml"))


def test_a_description_is_written_and_told(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "init", "walker.xml"]) == 0
    path = Path("sim/walker/robot.yaml")
    out = capsys.readouterr().out
    assert "found    left leg: 6 joints, foot left_foot" in out
    assert "guessed  stiffness, damping and torque of the drives" in out
    assert f"humanoid-bt check {path}" in out
    config = load_robot_config(path)
    assert (config.name, config.model) == ("walker", "../../walker.xml")
    assert RobotModel(config).joint_names  # it fits its model
    assert main(["fmt", "--check", str(path)]) == 0


def test_what_is_there_is_not_overwritten(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "init", "walker.xml", "--name", "mine"]) == 0
    before = Path("sim/mine/robot.yaml").read_text()
    Path("sim/mine/robot.yaml").write_text(before + "# mended\n")
    capsys.readouterr()
    assert main(["robots", "init", "walker.xml", "--name", "mine"]) == 2
    assert "is there already" in capsys.readouterr().err
    assert Path("sim/mine/robot.yaml").read_text() == before + "# mended\n"


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ([], "takes one model, not 0"),
        (["a.xml", "b.xml"], "takes one model, not 2"),
        (["nowhere.xml"], "there is no file 'nowhere.xml'"),
        (["walker.xml", "--name", "a/b"], "'a/b' is no name for a robot"),
        (["text.xml"], "text.xml: error: not a valid MJCF model"),
        (["room.xml"], "room.xml: error: no leg is on the left side of 'box'"),
        (["."], "'.' is a folder, not a model's file"),
        (["."], "it has: box.xml, fixed.xml, room.xml, text.xml, walker.xml"),
        (["box.xml"], "box.xml: error: no leg is on the left side of 'box'"),
        (["fixed.xml"], "fixed.xml: error: the model must have one free joint"),
    ],
)
def test_what_cannot_be_described_is_told(
    model: Path, arguments: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    body = '<body name="box">{}<geom size="0.1"/></body>'
    worlds = {
        "room": '<geom name="floor" type="plane" size="1 1 1"/>' + body.format("<freejoint/>"),
        "box": body.format("<freejoint/>"),
        "fixed": body.format(""),
    }
    for name, world in worlds.items():
        Path(f"{name}.xml").write_text(f"<mujoco><worldbody>{world}</worldbody></mujoco>")
    Path("text.xml").write_text("no model")
    assert main(["robots", "init", *arguments]) == 2
    assert says in capsys.readouterr().err
    assert not Path("sim").exists()


def test_what_cannot_be_written_is_told(model: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("sim").write_text("no folder")
    assert main(["robots", "init", "walker.xml"]) == 2
    assert capsys.readouterr().err == "error: 'sim/walker/robot.yaml' cannot be written: Not a directory\n"


def test_a_name_is_for_init(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["robots", "--name", "x"]) == 2
    assert "--name is for robots init" in capsys.readouterr().err


@pytest.mark.trials
def test_what_was_found_stands_and_walks(model: Path) -> None:
    model.write_text(model.read_text().replace("</mujoco>", f"<actuator>{_actuators()}</actuator></mujoco>"))
    assert main(["robots", "init", "walker.xml"]) == 0
    assert robot_problems(Path("sim/walker/robot.yaml")) == []


def _actuators() -> str:
    """Return motors as strong as the built-in robot's drives."""
    robot = RobotModel(load_robot_config(MODEL.with_name("robot.yaml")))
    return "".join(
        f'<motor joint="{name}" ctrllimited="true" ctrlrange="{-torque} {torque}"/>'
        for name, torque in zip(robot.joint_names, robot.torque_limit, strict=True)
    )
