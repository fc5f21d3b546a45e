"""Which body a run has: what robot.yaml says, or what the run says."""

from __future__ import annotations

import os
import re
import shutil
from pathlib import Path

import pytest

from humanoid_bt.checking import robot_motion
from humanoid_bt.cli import main
from humanoid_bt.control.body.policy import walker
from humanoid_bt.control.body.policy.learned_body import LearnedBody
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.robot.model import BASE_COORDINATES
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.session import Session
from tests.policy_files import write_standing_robot


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")
    model, standing = load_robot(Workspace(builtin_root()).find_robot("humanoid"))
    return write_standing_robot(tmp_path, model.joint_names, standing[BASE_COORDINATES:])


def body_of(session: Session) -> object:
    engine = session._drive.engine
    assert isinstance(engine, Lockstep)
    return engine.controller.body


def test_a_body_that_is_none_is_refused() -> None:
    with pytest.raises(UserError, match="'body' cannot be 'legs'") as caught:
        Session("stand", body="legs")  # type: ignore[arg-type]  # the mistake that is tried
    assert "dcm" in caught.value.problems[0].hint


def test_a_robot_without_a_walker_says_what_is_missing() -> None:
    with pytest.raises(UserError, match="there is no learned walker") as caught:
        Session("stand", body="policy")
    assert caught.value.problems[0].hint == "body: {walk: policy, policy: walk.policy.yaml}"


def test_the_run_has_the_last_word(robot: Path) -> None:
    assert isinstance(body_of(Session("stand", robot=robot)), LearnedBody)
    assert isinstance(body_of(Session("stand", robot=robot, body="dcm")), WholeBody)


def test_a_walker_that_does_not_walk_is_refused_in_its_own_file(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", str(robot)]) == 2
    told = capsys.readouterr().out
    assert "stand.policy.yaml:7:22: error: it does not walk 1 m straight ahead" in told
    assert "the order of joints and terms, scales, history" in told


def test_a_walker_whose_answers_are_not_finite_is_refused_for_that(
    robot: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(walker, "_finite", lambda *_: False)
    monkeypatch.setattr(robot_motion, "_WALK", 1)
    assert main(["check", str(robot)]) == 2
    told = capsys.readouterr().out
    assert "stand.policy.yaml:2:8: error: its body failed after 0.0 s: the policy's answer is not finite" in told
    assert told.endswith("1 error in 1 file\n")


def test_the_tree_runs_on_a_learned_walker(robot: Path) -> None:
    with Session("stand", robot=robot, duration=1.0) as session:
        report = session.run()
    assert (report.outcome, report.stops) == ("unfinished", [])


def test_a_robot_is_loaded_again_once_a_file_of_it_changes(robot: Path) -> None:
    before = load_robot(robot)
    assert load_robot(robot) is before
    for name in ("robot.yaml", "humanoid.xml", "stand.policy.yaml", "stand.onnx"):
        now = (robot.parent / name).stat().st_mtime_ns
        os.utime(robot.parent / name, ns=(now + 1_000_000, now + 1_000_000))
        after = load_robot(robot)
        assert after is not before, name
        before = after


def test_a_robot_is_loaded_again_once_a_file_that_its_model_includes_changes(tmp_path: Path) -> None:
    builtin = Workspace(builtin_root()).find_robot("humanoid")
    shutil.copy(builtin, tmp_path / "robot.yaml")
    shutil.copy(builtin.with_name("humanoid.xml"), tmp_path / "parts.xml")
    (tmp_path / "humanoid.xml").write_text('<mujoco><include file="parts.xml"/></mujoco>')
    before = load_robot(tmp_path / "robot.yaml")
    assert load_robot(tmp_path / "robot.yaml") is before
    parts = (tmp_path / "parts.xml").read_text()
    (tmp_path / "parts.xml").write_text(parts.replace('name="pelvis" class="solid"', 'class="solid" name="pelvis" ', 1))
    assert load_robot(tmp_path / "robot.yaml") is not before


@pytest.mark.parametrize(
    ("angle", "where", "told"),
    [
        (
            "-40",
            "4:81",
            "error: the default angle of 'left_hip_pitch', -40 rad, is outside its soft limits [home-outside]",
        ),
        ("0.3", "4:15", "warning: the soles do not mirror each other in the home posture: 38 cm off [asymmetric]"),
    ],
)
def test_a_wrong_default_pose_is_told_where_it_is_written(
    robot: Path, capsys: pytest.CaptureFixture[str], angle: str, where: str, told: str
) -> None:
    policy = robot.parent / "stand.policy.yaml"
    policy.write_text(re.sub(r"left_hip_pitch: [-\d.]+", f"left_hip_pitch: {angle}", policy.read_text()))
    assert main(["check", str(robot)]) == 2
    out = capsys.readouterr().out
    assert f"stand.policy.yaml:{where}: {told}" in out
    assert "is it in rad, and in the order of joints?" in out
    assert "robot.yaml:" not in out


def test_a_wrong_angle_of_a_listed_default_pose_is_told_where_it_is_written(
    robot: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    policy = robot.parent / "stand.policy.yaml"
    angles = re.findall(r"[-\d.]+(?=[,}])", policy.read_text().splitlines()[3])
    listed = ", ".join(["99", *angles[1:]])
    policy.write_text(re.sub("default_pose: {.*}", f"default_pose: [{listed}]", policy.read_text()))
    assert main(["check", str(robot)]) == 2
    assert "stand.policy.yaml:4:16: error: the default angle of" in capsys.readouterr().out


def test_a_walker_that_cannot_step_back_is_told_so(robot: Path, capsys: pytest.CaptureFixture[str]) -> None:
    policy = robot.parent / "stand.policy.yaml"
    policy.write_text(policy.read_text().replace("vx: [-1, 1], vy: [-1, 1]", "vx: [0, 1], vy: [0, 0]"))
    assert main(["check", str(robot)]) == 2
    told = capsys.readouterr().out
    assert "stand.policy.yaml:8:10: error: it does not walk 1 m straight ahead" in told
    assert "by the ranges of command it cannot walk backward or walk to the right or walk to the left\n" in told
