"""Skills on robots that lack hands or a neck."""

import shutil
from pathlib import Path

import pytest

from humanoid_bt import Rig, Workspace

BUILTIN = Path(__file__).resolve().parents[2] / "sim" / "humanoid"
HANDS = """\
hands:
  left: {body: left_hand, position: [0, 0, -0.10]}
  right: {body: right_hand, position: [0, 0, -0.10]}
"""
NECK = "neck: {yaw: neck_yaw, pitch: neck_pitch}\n"


def without(what: str, folder: Path) -> Rig:
    """Return the built-in robot without something that its robot.yaml says."""
    robot = folder / "sim" / "lesser"
    robot.mkdir(parents=True)
    shutil.copy(BUILTIN / "humanoid.xml", robot)
    text = (BUILTIN / "robot.yaml").read_text()
    assert what in text
    (robot / "robot.yaml").write_text(text.replace(what, ""))
    return Rig(Workspace(folder), "lesser")


@pytest.fixture(scope="module")
def handless(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    return without(HANDS, tmp_path_factory.mktemp("handless"))


@pytest.mark.parametrize(("skill", "hand"), [("wave", "right"), ("offer", "left"), ("retract", "left")])
def test_a_robot_without_hands_is_told_so(handless: Rig, skill: str, hand: str) -> None:
    handless.reset()
    handless.see("person", (1.0, 0.2, 1.2))
    handless.settle(0.5)
    values = {} if skill == "retract" else {"target": "person", "hand": hand}
    result = handless.run(skill, **values)
    assert result.failed
    assert result.feedback == f"the robot has no {hand} hand"


def test_a_robot_without_a_neck_looks_with_its_torso(tmp_path: Path) -> None:
    rig = without(NECK, tmp_path)
    aside = rig.run("look_at", target=(1.0, 0.7, rig.state.gaze_position[2]))
    assert aside.succeeded, aside.feedback
    rig.reset()
    below = rig.run("look_at", target=(1.0, 0.0, 0.3), patience=0.5)
    assert below.failed
    assert "comes no nearer" in below.feedback
