"""A robot.yaml that does not fit its model is caught, with the line that is wrong and what would be right."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from humanoid_bt.checking.check import checked
from humanoid_bt.checking.robot_reach import reached
from humanoid_bt.checking.robot_trial import Trial
from humanoid_bt.core.errors import Problem
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.robot.published import read_model
from humanoid_bt.robot.survey.description import describe
from tests.line_feet import write_line_feet
from tests.published import published_robot

BUILTIN = builtin_root() / "sim" / "humanoid"
LEFT_SOLE = "sole: {body: left_foot, position: [0.03, 0, -0.06]}"
HANDS = """\
  left: {body: left_hand, position: [0, 0, -0.10]}
  right: {body: right_hand, position: [0, 0, -0.10]}
"""
SWAPPED_HANDS = """\
  left: {body: right_hand, position: [0, 0, -0.10]}
  right: {body: left_hand, position: [0, 0, -0.10]}
"""
LEFT_KNEE = '{joints: ["*_knee"], stiffness: 500, damping: 20, torque: 150}'
GAZE = "gaze: {body: head, position: [0.09, 0, 0.08]}"
SHOULDERS = '{joints: ["*_shoulder_pitch", "*_shoulder_roll"], stiffness: 120, damping: 6, torque: 40}'
SHELF = """\
collision:
  capsules:
    - {body: torso, start: [0.44, -0.3, -0.02], end: [0.44, 0.3, -0.02], radius: 0.17}"""
RIGHT_FOOT = '<geom name="right_foot" class="sole" size="0.105 0.045 0.015"'
ANKLE_ROLL = '<joint name="left_ankle_roll" axis="1 0 0"'
NECK_PITCH = '<joint name="neck_pitch" axis="0 1 0" range="-0.6 0.8"/>'


@dataclass(frozen=True)
class Break:
    """One way to break the built-in robot.

    Attributes:
        old, new: text of robot.yaml, or of the model if it begins with a bracket.
        code: of the finding.
        says: a part of its message or its hint.
        at: what stands in the line it points to; by default what was changed.
    """

    old: str
    new: str
    code: str
    says: str
    at: str = ""


BREAKS = {
    "sole 13 cm too high": Break(
        LEFT_SOLE, LEFT_SOLE.replace("-0.06", "0.07"), "sole-off", "13.0 cm above the foot's lowest point"
    ),
    "sole beside the foot": Break(
        LEFT_SOLE, LEFT_SOLE.replace("0.03,", "0.09,"), "sole-off", "around position: [0.030, 0.000, -0.060]"
    ),
    "sole too long": Break("half_length: 0.105", "half_length: 0.21", "sole-size", "of the foot: 0.105 m"),
    "one foot shorter": Break(
        RIGHT_FOOT, RIGHT_FOOT.replace("0.105", "0.08"), "sole-size", "of the foot: 0.080 m", "half_length: 0.105"
    ),
    "pitch for roll": Break(
        "ankle_roll: left_ankle_roll",
        "ankle_roll: left_ankle_pitch",
        "joint-role",
        "of this leg these turn about x: left_hip_roll, left_ankle_roll",
    ),
    "oblique roll": Break(
        ANKLE_ROLL,
        ANKLE_ROLL.replace("1 0 0", "2 2 1"),
        "joint-role",
        "'left_ankle_roll' turns about [0.667, 0.667, 0.333], an ankle_roll joint about x",
        "ankle_roll: left_ankle_roll",
    ),
    "ankle for hip": Break(
        "hip_roll: left_hip_roll", "hip_roll: left_ankle_roll", "joint-role", "'left_ankle_roll' is no hip joint"
    ),
    "knee for hip": Break(
        "hip_pitch: left_hip_pitch", "hip_pitch: left_knee", "joint-role", "'left_knee' is no hip joint"
    ),
    "knee for ankle": Break(
        "ankle_pitch: left_ankle_pitch", "ankle_pitch: left_knee", "joint-role", "'left_knee' is no ankle joint"
    ),
    "the other leg's joint": Break(
        "hip_pitch: left_hip_pitch", "hip_pitch: right_hip_pitch", "joint-role", "does not move the left sole"
    ),
    "wrong sign": Break(
        '<joint name="left_hip_pitch" axis="0 1 0"',
        '<joint name="left_hip_pitch" axis="0 -1 0"',
        "asymmetric",
        "the soles do not mirror each other in the home posture",
        "left:",
    ),
    "legs swapped": Break(
        "  left:\n    hip_roll",
        "  right:\n    hip_roll",
        "swapped-sides",
        "left and right are swapped",
        "sole: {body: right_foot",
    ),
    "hands swapped": Break(HANDS, SWAPPED_HANDS, "swapped-sides", "left and right are swapped", "{body: right_hand"),
    "both hands on one arm": Break(
        "left: {body: left_hand", "left: {body: right_hand", "swapped-sides", "the palms of both sides are on the same"
    ),
    "a hand is missing": Break(
        HANDS.splitlines()[0] + "\n", "", "missing-key", "a left arm, and 'hands' has no key", "{body: right_hand"
    ),
    "palm in centimetres": Break(
        "right_hand, position: [0, 0, -0.10]", "right_hand, position: [0, 0, -10]", "site-off", "right palm is 982"
    ),
    "camera in a foot": Break(GAZE, GAZE.replace("head", "left_foot"), "site-off", "below the base"),
    "camera in centimetres": Break(GAZE, GAZE.replace("0.08", "8"), "site-off", "away from the body 'head'"),
    "neck's joints swapped": Break(
        "{yaw: neck_yaw, pitch: neck_pitch}",
        "{yaw: neck_pitch, pitch: neck_yaw}",
        "joint-role",
        "turns about y, the neck's yaw about z",
    ),
    "wrong torso": Break("torso: torso", "torso: head", "wrong-torso", "does not carry"),
    "crouched beyond the limits": Break('"*_knee": 0.70', '"*_knee": 3.0', "home-outside", "valid: "),
    "an arm's sign": Break(
        "right_shoulder_roll: -0.15",
        "right_shoulder_roll: 0.15",
        "asymmetric",
        "the palms do not mirror",
        '"*_hip_pitch": -0.35',
    ),
    "soft knees": Break(
        LEFT_KNEE, LEFT_KNEE.replace("500, damping: 20", "2, damping: 0.1"), "soft-drive", "_knee' is too soft"
    ),
    "weak knees": Break(LEFT_KNEE, LEFT_KNEE.replace("150", "15"), "does-not-walk", "raise its torque"),
    "weak shoulders": Break(
        "stiffness: 120, damping: 6, torque: 40",
        "stiffness: 120, damping: 6, torque: 0.2",
        "weak-drive",
        "raise its torque",
    ),
    "feet too near": Break(
        "step_turn:", "stance_width: 0.085\n  step_turn:", "self-contact", "touch each other", "stance_width"
    ),
    "falls at once": Break("gait:", "fall: {tilt: 0.01}\ngait:", "fall-limits", "counts as falling", "fall:"),
    "wider than it says": Break(
        "gait:", "walking_radius: 0.2\ngait:", "walking-radius", "'left_hand' is 0.28 m from", "walking_radius:"
    ),
    "speeds too noisy to feel with": Break(
        GAZE, f"sensors: {{encoders: {{speed_noise: 0.2}}}}\n{GAZE}", "false-contact", "sensors.encoders", "format:"
    ),
    "never falls": Break("gait:", "fall: {height: 0.05}\ngait:", "fall-limits", "not noticed", "fall:"),
    "shoulders that lift nothing": Break(
        SHOULDERS, SHOULDERS.replace("torque: 40", "torque: 3"), "does-not-reach", "'left_shoulder_pitch' is 0.2"
    ),
    "a neck that turns on and on": Break(
        NECK_PITCH,
        NECK_PITCH.replace('range="-0.6 0.8"', 'limited="false"'),
        "no-joint-limits",
        "'neck_pitch' has no limits: control turns it as far as it likes",
        "model:",
    ),
    "a shelf in the way": Break(GAZE, f"{SHELF}\n{GAZE}", "does-not-reach", "the torso is in the way", "capsules:"),
    "a neck that looks up": Break(
        NECK_PITCH, NECK_PITCH.replace("-0.6 0.8", "-0.5 -0.1"), "does-not-look", "model: 'neck_pitch'", "gaze:"
    ),
}
ALIKE = (
    "never falls",
    "wrong sign",
    "wider than it says",
    "weak shoulders",
    "a neck that looks up",
    "an arm's sign",
    "a neck that turns on and on",
    "feet too near",
)
"""Those for which the robot moves for seconds, as it does for others that ``make test`` tries."""


def found(folder: Path) -> list[Problem]:
    return checked(folder / "robot.yaml", Workspace(folder))


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A copy of the built-in robot."""
    folder = tmp_path / "sim" / "mine"
    shutil.copytree(BUILTIN, folder)
    return folder


@pytest.mark.parametrize("way", [pytest.param(way, marks=pytest.mark.trials if way in ALIKE else ()) for way in BREAKS])
def test_what_does_not_fit_is_caught_where_it_is_written(robot: Path, way: str) -> None:
    broken = BREAKS[way]
    file = robot / ("humanoid.xml" if broken.old.startswith("<") else "robot.yaml")
    text = file.read_text()
    assert broken.old in text
    changed = text.replace(broken.old, broken.new, 1)
    if way == "legs swapped":
        changed = changed.replace("  right:\n    hip_roll: right", "  left:\n    hip_roll: right", 1)
    file.write_text(changed)
    problems = found(robot)
    fitting = [problem for problem in problems if problem.code == broken.code]
    assert fitting, problems
    said = [problem for problem in fitting if broken.says in f"{problem.message}\n{problem.hint}"]
    assert said, fitting
    assert said[0].hint
    place = said[0].place
    assert place is not None and place.line
    line = Path(place.file).read_text().splitlines()[place.line - 1]
    assert (broken.at or broken.new.splitlines()[-1].strip()) in line


G1 = """\
format: 1
name: g1
model: {model}
base: pelvis
torso: torso_link
legs:
  left:
    hip_roll: left_hip_roll_joint
    hip_pitch: left_hip_pitch_joint
    ankle_pitch: left_ankle_pitch_joint
    ankle_roll: left_ankle_roll_joint
    sole: {{body: left_ankle_roll_link, position: [0.035, 0, -0.031]}}
  right:
    hip_roll: right_hip_roll_joint
    hip_pitch: right_hip_pitch_joint
    ankle_pitch: right_ankle_pitch_joint
    ankle_roll: right_ankle_roll_joint
    sole: {{body: right_ankle_roll_link, position: [0.035, 0, -0.031]}}
sole: {{half_length: 0.095, half_width: 0.021, margin: 0.008}}
hands:
  left: {{body: left_elbow_roll_link, position: [0.18, 0, 0]}}
  right: {{body: right_elbow_roll_link, position: [0.18, 0, 0]}}
gaze: {{body: torso_link, position: [0.06, 0, 0.42], down: 0.8}}
drives:
  - {{joints: ["*_hip_pitch_joint", "*_hip_roll_joint"], stiffness: 500, damping: 20, torque: 120}}
  - {{joints: ["*_knee_joint"], stiffness: 500, damping: 20, torque: 150}}
  - {{joints: ["*_hip_yaw_joint", torso_joint], stiffness: 300, damping: 12, torque: 80}}
  - {{joints: ["*_ankle_*"], stiffness: 200, damping: 8, torque: 50}}
  - {{joints: ["*_shoulder_*", "*_elbow_*"], stiffness: 100, damping: 5, torque: 25}}
  - {{joints: ["*"], stiffness: 5, damping: 0.2, torque: 2}}
home:
  "*_hip_pitch_joint": -0.35
  "*_knee_joint": 0.70
  "*_ankle_pitch_joint": -0.35
  "*_shoulder_pitch_joint": 0.3
  left_shoulder_roll_joint: 0.2
  right_shoulder_roll_joint: -0.2
  "*_elbow_pitch_joint": 1.2
gait: {{stance_width: 0.22, separation_min: 0.17}}
"""


@pytest.fixture
def published(tmp_path: Path) -> Path:
    """A robot.yaml for a published model, which is no part of this package."""
    (tmp_path / "robot.yaml").write_text(G1.format(model=published_robot("unitree_g1/g1.xml")))
    return tmp_path


def test_the_built_in_robot_has_no_findings(robot: Path) -> None:
    assert found(robot) == []


def test_a_link_that_keeps_the_head_from_looking_down_is_named(robot: Path) -> None:
    model, file = robot / "humanoid.xml", robot / "robot.yaml"
    model.write_text(model.read_text().replace('<exclude body1="torso" body2="head"/>', ""))
    chin = "- {body: head, start: [0.16, 0, -0.1], end: [0.16, 0, -0.1], radius: 0.025}"
    file.write_text(f"{file.read_text()}\ncollision:\n  capsules:\n    {chin}\n")
    (problem,) = found(robot)
    assert problem.code == "does-not-look"
    assert problem.message.endswith("'head' is kept 5 mm from 'torso'")


def test_sensors_that_err_by_more_than_a_light_drive_gives_make_it_neither_soft_nor_weak(robot: Path) -> None:
    file = robot / "robot.yaml"
    file.write_text(f"{file.read_text()}\nsensors: {{encoders: {{noise: 0.01, torque_noise: 100}}}}\n")
    trial = Trial(RobotModel(load_robot_config(file)))
    trial.run(0.1)
    assert not trial.seen.saturated.any()
    assert trial.seen.held.max() < 60


def test_a_stop_while_the_hands_reach_is_told_with_its_reason(robot: Path) -> None:
    trial = Trial(RobotModel(load_robot_config(robot / "robot.yaml")))
    trial.run(0.5)
    trial.plant.fail_sensor("left_elbow", "silent")
    (problem,) = reached(trial)
    assert "it stops as its hands reach ahead: a sensor failed" in problem.message


def test_a_model_in_millimetres_is_told_before_all_else(robot: Path) -> None:
    spec = read_model(robot / "humanoid.xml")
    for body in spec.bodies[1:]:
        body.pos = 1000 * body.pos
    (robot / "humanoid.xml").write_text(spec.to_xml())
    (problem,) = found(robot)
    assert problem.code == "odd-size"
    assert "m high, expected: 0.1 to 5 m; lengths of the model, and of its meshes, must be in metres" in problem.message
    assert problem.place is not None
    assert (robot / "robot.yaml").read_text().splitlines()[problem.place.line - 1].startswith("model:")


def test_a_home_posture_beyond_the_limits_is_told_alone(robot: Path) -> None:
    file = robot / "robot.yaml"
    file.write_text(file.read_text().replace('"*_knee": 0.70', '"*_knee": 3.5'))
    assert [problem.code for problem in found(robot)] == ["home-outside"]


@pytest.mark.trials
def test_joints_may_be_meant_to_have_no_limits(robot: Path) -> None:
    model, file = robot / "humanoid.xml", robot / "robot.yaml"
    model.write_text(model.read_text().replace(NECK_PITCH, NECK_PITCH.replace('range="-0.6 0.8"', 'limited="false"')))
    file.write_text(file.read_text().replace("\nmodel:", "\n# allow no-joint-limits: the head turns on\nmodel:"))
    assert found(robot) == []


def test_a_hip_that_is_named_as_the_ankle_too_is_a_hip(robot: Path) -> None:
    file = robot / "robot.yaml"
    file.write_text(file.read_text().replace("ankle_pitch: left_ankle_pitch", "ankle_pitch: left_hip_pitch"))
    (problem,) = found(robot)
    assert problem.message == "'left_hip_pitch' is no ankle joint"


def test_an_ankle_that_rolls_must_be_named(robot: Path) -> None:
    file = robot / "robot.yaml"
    for side in ("left", "right"):
        file.write_text(file.read_text().replace(f"    ankle_roll: {side}_ankle_roll\n", ""))
    left, right = found(robot)
    assert left.message == "'left_ankle_roll' tilts the left foot sideways, and no ankle_roll is named"
    assert (left.code, left.hint, right.hint) == (
        "joint-role",
        "ankle_roll: left_ankle_roll",
        "ankle_roll: right_ankle_roll",
    )


def test_a_robot_whose_ankles_only_pitch_stands_and_walks(tmp_path: Path) -> None:
    write_line_feet(tmp_path)
    assert found(tmp_path) == []


@pytest.mark.trials
def test_a_hip_may_roll_below_where_it_pitches(tmp_path: Path) -> None:
    write_line_feet(tmp_path)
    model = read_model(tmp_path / "humanoid.xml")
    for side in ("left", "right"):
        roll, pitch = model.joint(f"{side}_hip_roll"), model.joint(f"{side}_hip_pitch")
        roll.axis, pitch.axis = pitch.axis.copy(), roll.axis.copy()
        roll.range, pitch.range = pitch.range.copy(), roll.range.copy()
        roll.name = "other"
        pitch.name, roll.name = f"{side}_hip_roll", f"{side}_hip_pitch"
    (tmp_path / "humanoid.xml").write_text(model.to_xml())
    assert found(tmp_path) == []


@pytest.mark.trials
def test_a_published_robot_has_no_findings(published: Path) -> None:
    assert found(published) == []


@pytest.mark.trials
def test_a_published_robot_whose_ankles_only_pitch_has_no_findings_as_init_describes_it(tmp_path: Path) -> None:
    file = published_robot("unitree_h1/h1.xml")
    text = describe(read_model(file).compile(), "h1", str(file)).text
    (tmp_path / "robot.yaml").write_text(text)
    assert found(tmp_path) == []


@pytest.mark.trials
def test_a_robot_whose_joints_turn_the_other_way_stands_and_walks(tmp_path: Path) -> None:
    spec = read_model(BUILTIN / "humanoid.xml")
    for joint in spec.joints:
        if joint.name.startswith(("left_hip", "right_ankle", "neck_")):
            joint.axis, joint.range = -joint.axis, [-joint.range[1], -joint.range[0]]
    (tmp_path / "humanoid.xml").write_text(spec.to_xml())
    text = describe(spec.compile(), "mirrored", "humanoid.xml").text
    (tmp_path / "robot.yaml").write_text(text)
    assert found(tmp_path) == []


@pytest.mark.trials
def test_a_published_robot_is_taken_out_of_its_scene(published: Path) -> None:
    file = published / "robot.yaml"
    file.write_text(file.read_text().replace("g1.xml", "scene.xml"))
    assert found(published) == []


def test_a_sole_that_is_wider_than_a_published_foot_is_caught(published: Path) -> None:
    file = published / "robot.yaml"
    file.write_text(file.read_text().replace("half_width: 0.021", "half_width: 0.025"))
    assert [problem.code for problem in found(published)] == ["sole-size"]
