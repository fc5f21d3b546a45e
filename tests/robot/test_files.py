"""Which files a robot is made of."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.files import files_of
from tests.policy_files import write_walker

HUMANOID = builtin_root() / "sim" / "humanoid"
MODEL = '<mujoco><include file="defaults.xml"/><!-- <include file="old.xml"/> --><include file="gone.xml"/>'
MODEL += '<asset><model name="arm" file="arm/arm.xml"/></asset></mujoco>'


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A ``robot.yaml`` whose model is in several files."""
    shutil.copy(HUMANOID / "robot.yaml", tmp_path)
    (tmp_path / "humanoid.xml").write_text(MODEL)
    (tmp_path / "defaults.xml").write_text('<mujocoinclude><include file="parts/hand.xml"/></mujocoinclude>')
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "hand.xml").write_text('<mujocoinclude><include file="defaults.xml"/></mujocoinclude>')
    (tmp_path / "arm").mkdir()
    (tmp_path / "arm" / "arm.xml").write_text('<mujoco><include file="wrist.xml"/></mujoco>')
    (tmp_path / "arm" / "wrist.xml").write_text("<mujocoinclude/>")
    (tmp_path / "old.xml").write_text("<mujocoinclude/>")
    write_walker(tmp_path)
    (tmp_path / "walk.onnx.data").write_bytes(b"weights")
    (tmp_path / "own.py").write_text("")
    return tmp_path / "robot.yaml"


@pytest.mark.parametrize(
    ("walk", "more"),
    [("dcm", set()), ("own", {"own.py"}), ("policy", {"walk.policy.yaml", "walk.onnx", "walk.onnx.data"})],
)
def test_the_files_of_a_robot_are_those_that_it_needs(robot: Path, walk: str, more: set[str]) -> None:
    body = f"\nbody: {{walk: {walk}, policy: walk.policy.yaml, own: own.py}}\n"
    robot.write_text(robot.read_text() + body)
    names = {str(file.relative_to(robot.parent)) for file in files_of(load_robot_config(robot))}
    parts = {"defaults.xml", "parts/hand.xml", "arm/arm.xml", "arm/wrist.xml"}
    assert names == {"robot.yaml", "humanoid.xml", *parts, *more}


def test_a_model_that_is_no_xml_is_a_file_all_the_same(robot: Path) -> None:
    robot.with_name("humanoid.xml").write_text("<mujoco>")
    assert robot.with_name("humanoid.xml") in files_of(load_robot_config(robot))
