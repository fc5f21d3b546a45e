"""Skills on robots that lack hands or a neck."""

import math
import shutil
from pathlib import Path

import pytest

from humanoid_bt import Rig, Stage, UserError, Workspace, run

BUILTIN = Path(__file__).resolve().parents[2] / "sim" / "humanoid"
HANDS = """\
hands:
  left: {body: left_hand, position: [0, 0, -0.10]}
  right: {body: right_hand, position: [0, 0, -0.10]}
"""
RIGHT_HAND = "  right: {body: right_hand, position: [0, 0, -0.10]}\n"
NECK = "neck: {yaw: neck_yaw, pitch: neck_pitch}\n"


LOW = """\
format: 1
name: low
objects: {ball: {shape: ball, size: [8 cm], position: [1.1, 0.15, 0.6], stand: true}}
percepts: {target: {object: ball}}
"""
HALF_VIEW = math.radians(40)  # up and down, of a percept by default


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


@pytest.fixture(scope="module")
def one_handed(tmp_path_factory: pytest.TempPathFactory) -> Rig:
    return without(RIGHT_HAND, tmp_path_factory.mktemp("one_handed"))


@pytest.mark.parametrize(
    ("skill", "hand"),
    [("wave", "right"), ("offer", "left"), ("retract", "left"), ("point_at", "right"), ("touch_with_both", "left")],
)
def test_a_robot_without_hands_is_told_so(handless: Rig, skill: str, hand: str) -> None:
    handless.reset()
    handless.see("person", (1.0, 0.2, 1.2))
    handless.settle(0.5)
    values = {} if skill == "retract" else {"target": "person", "hand": hand}
    if skill == "touch_with_both":
        values = {"target": "person", "width": 0.2}
    result = handless.run(skill, **values)
    assert result.failed
    assert result.feedback == f"the robot has no {hand} hand"


@pytest.mark.parametrize("skill", ["reach", "point_at", "offer", "wave"])
def test_a_robot_with_one_hand_uses_it_for_what_is_on_the_other_side(one_handed: Rig, skill: str) -> None:
    one_handed.reset()
    one_handed.see("thing", (0.4, -0.1, 0.9))
    result = one_handed.run(skill, target="thing", timeout=8)
    assert result.succeeded, result.feedback
    assert "left hand" in result.feedback


def test_a_tree_runs_on_a_robot_with_one_hand_unless_it_names_the_other_one(tmp_path: Path) -> None:
    workspace = without(RIGHT_HAND, tmp_path).workspace
    stage = Stage(workspace, "lesser", "random_target", dry=True)
    assert stage.run("fetch", seed=1).succeeded
    trees = tmp_path / "trees"
    trees.mkdir()
    (trees / "hail.yaml").write_text("format: 1\nname: hail\nroot: {emergency_stop: {wave: {times: 1}}}\n")
    assert stage.run("hail").succeeded
    (trees / "other.yaml").write_text("format: 1\nname: other\nroot: {reach: {target: target, hand: right}}\n")
    with pytest.raises(UserError, match=r"'reach' commands right_hand: the robot 'humanoid' has none"):
        stage.run("other")


def test_a_robot_without_a_neck_looks_with_its_torso(tmp_path: Path) -> None:
    rig = without(NECK, tmp_path)
    aside = rig.run("look_at", target=(1.0, 0.7, rig.state.gaze_position[2]))
    assert aside.succeeded, aside.feedback
    rig.reset()
    below = rig.run("look_at", target=(1.0, 0.0, 0.3), patience=0.5)
    assert below.failed
    assert "comes no nearer" in below.feedback


def test_a_robot_without_a_neck_leans_to_keep_in_view_what_is_near(tmp_path: Path) -> None:
    rig = without(NECK, tmp_path)
    target = (0.45, 0.05, 0.65)
    result = rig.run("look_at", target=target, timeout=4)
    state = result.states[-1]
    ahead, _, above = (float(part) for part in target - state.gaze_position)
    below = -math.atan2(above, ahead) - math.asin(-state.gaze_direction[2])
    assert below < HALF_VIEW
    assert not result.stops
    first = result.states[0]
    assert math.atan2(first.gaze_position[2] - target[2], target[0] - first.gaze_position[0]) > HALF_VIEW


@pytest.mark.trials
def test_a_robot_without_a_neck_does_not_lose_what_it_walks_up_to(tmp_path: Path) -> None:
    workspace = without(NECK, tmp_path).workspace
    (tmp_path / "sim" / "scenes").mkdir()
    (tmp_path / "sim" / "scenes" / "low.yaml").write_text(LOW)
    report = run("fetch", workspace=workspace, robot="lesser", scene="low", duration=30, record=False)
    assert report.outcome == "success", report.reason
    assert not [entry for entry in report.timeline if entry["path"].endswith("idle") and entry["time"] > 0.2]
