"""What is found in a model that nobody has described: the built-in one, changed in ways that published ones differ."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pytest
import yaml

from humanoid_bt.core.messages import SIDES, Side
from humanoid_bt.files.formatting import formatted
from humanoid_bt.files.workspace import builtin_root
from humanoid_bt.robot.config import ContactConfig, GaitConfig, RobotConfig, load_robot_config
from humanoid_bt.robot.footprint import footprint
from humanoid_bt.robot.model import GAZE_SITE, RobotModel, palm_site, sole_site
from humanoid_bt.robot.published import read_model
from humanoid_bt.robot.survey.description import Description, describe
from humanoid_bt.robot.survey.limbs import NoHumanoidError, Surveyor
from humanoid_bt.robot.survey.posture import overlapping
from tests.published import published_robot

BUILTIN = builtin_root() / "sim" / "humanoid"

Adopt = Callable[[mujoco.MjSpec], tuple[Description, RobotConfig]]


@pytest.fixture
def spec() -> mujoco.MjSpec:
    spec = read_model(BUILTIN / "humanoid.xml")
    for exclude in list(spec.excludes):  # which name bodies that tests rename and remove
        spec.delete(exclude)
    return spec


@pytest.fixture
def adopt(tmp_path: Path) -> Adopt:
    def adopt(spec: mujoco.MjSpec) -> tuple[Description, RobotConfig]:
        description = describe(spec.compile(), "found", "model.xml")
        (tmp_path / "model.xml").write_text(spec.to_xml())
        (tmp_path / "robot.yaml").write_text(description.text)
        return description, load_robot_config(tmp_path / "robot.yaml")

    return adopt


def test_what_is_found_is_what_the_robots_own_description_says(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    own = load_robot_config(BUILTIN / "robot.yaml")
    description, found = adopt(spec)
    assert (found.base, found.torso, found.neck, found.gaze.body) == (own.base, own.torso, own.neck, own.gaze.body)
    for side in SIDES:
        assert found.legs[side] == own.legs[side]
        assert (found.hands[side].body, found.hands[side].position) == (own.hands[side].body, own.hands[side].position)
    assert (found.sole.half_length, found.sole.half_width) == (own.sole.half_length, own.sole.half_width)
    assert {name: set(joints) for name, joints in found.groups.items()} == {
        name: {joint for joint in RobotModel(own).joint_names if own.group(joint) == name} for name in own.groups
    }
    assert description.missing == ()


def test_links_that_are_in_what_carries_them_do_not_touch(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    description, found = adopt(spec)
    assert found.collision.overlap["pelvis"] == ["left_thigh", "right_thigh"]
    assert "links whose shapes are in each other, which do not touch" in description.guessed
    assert adopt(read_model(BUILTIN / "humanoid.xml"))[1].collision.overlap == {}


def test_links_that_touch_by_their_posture_do_touch() -> None:
    ball = "<joint/><geom size='.1'/>"
    limb = f"<body pos='.15 0 0'>{ball}<body pos='.3 0 0'>{ball}</body></body><body pos='.15 .1 0'>{ball}</body>"
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody><body><freejoint/><geom size='.1'/>{limb}</body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert {tuple(sorted(model.geom_bodyid[pair])) for pair in data.contact.geom} == {(2, 4)}
    assert overlapping(model, model.qpos0) == {}  # a joint joins the others; these are two branches


def test_the_first_shift_is_longer_on_narrow_soles(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    assert adopt(spec)[1].gait.first_shift == GaitConfig.first_shift
    for side in SIDES:
        for geom in spec.body(f"{side}_foot").geoms:
            geom.size[1] = 0.02
    narrow = adopt(spec)[1]
    assert 0.45 < narrow.gait.first_shift < 0.65


def test_feet_on_narrow_soles_stand_and_come_nearer_to_each_other(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side, sign in zip(SIDES, (1, -1), strict=True):
        spec.body(f"{side}_hip_yaw_link").pos[1] = sign * 0.12
    gait = adopt(spec)[1].gait
    assert (gait.stance_width, gait.separation_min) == (0.20, 0.15)  # soles of 9 cm
    for side in SIDES:
        for geom in spec.body(f"{side}_foot").geoms:
            geom.size[1] = 0.025
    gait = adopt(spec)[1].gait
    assert (gait.stance_width, gait.separation_min) == (0.20, 0.11)
    for side in SIDES:
        spec.delete(spec.joint(f"{side}_ankle_roll"))
    gait = adopt(spec)[1].gait
    assert (gait.stance_width, gait.separation_min) == (0.24, 0.19)  # its legs must be upright


def test_feet_do_not_stand_nearer_than_hips_that_are_near(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    gait = adopt(spec)[1].gait
    assert (gait.stance_width, gait.separation_min) == (0.17, 0.12)


def test_a_sole_is_not_to_bear_near_toe_and_heel_where_it_would_pivot(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    sole = adopt(spec)[1].sole
    assert sole.bears[0] == pytest.approx(0.8 * sole.half_length, abs=1e-3)
    assert sole.bears[1] == pytest.approx(sole.half_width - 0.012, abs=1e-3)


def test_a_light_robot_is_kept_from_spinning_as_firmly_as_a_heavy_one(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    heavy = adopt(spec)[1].whole_body.spin
    for body in spec.bodies:
        for geom in body.geoms:
            geom.mass = 0.5 * geom.mass if geom.mass > 0 else geom.mass
            geom.density = 0.5 * geom.density
    light = adopt(spec)[1].whole_body.spin
    assert light == pytest.approx(2 * heavy, rel=0.05)


def test_steps_turn_less_on_hips_that_turn_little(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    assert adopt(spec)[1].gait.step_turn == GaitConfig.step_turn
    spec.joint("right_hip_yaw").range = [-0.4, 0.6]
    assert adopt(spec)[1].gait.step_turn == pytest.approx(0.4)
    spec.joint("right_hip_yaw").range = [-0.9, 0.0]
    assert adopt(spec)[1].gait.step_turn == pytest.approx(0.05)


def test_feet_roll_where_ankles_can_and_knees_straighten_where_they_are_bent(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    gait = adopt(spec)[1].gait
    assert (gait.toe_off, gait.heel_strike) == (0.15, 0.15)
    assert gait.rise == pytest.approx(0.02, abs=2e-3)  # as the robot's own description says
    ankle, knee = (spec.joint(f"left_{name}") for name in ("ankle_pitch", "knee"))
    usual, ankle.range = ankle.range.copy(), [-0.54, 0.54]  # it stands at -0.35
    gait = adopt(spec)[1].gait
    assert (gait.toe_off, gait.heel_strike) == (0.0, 0.0)
    assert gait.rise > 0.0
    ankle.range, knee.range = usual, [0.0, 0.3]
    gait = adopt(spec)[1].gait
    assert (gait.toe_off, gait.rise) == (0.15, 0.0)


def test_narrow_soles_land_flat(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in ("left", "right"):
        for geom in spec.body(f"{side}_foot").geoms:
            geom.size[1] = min(geom.size[1], 0.022)
    gait = adopt(spec)[1].gait
    assert (gait.toe_off, gait.heel_strike) == (0.15, 0.0)


def test_names_do_not_matter(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for kind, things in (("b", spec.bodies[1:]), ("j", spec.joints), ("s", spec.sites)):
        for number, thing in enumerate(things):
            thing.name = f"{kind}{number}"
    model = spec.compile()
    limbs = Surveyor(model).limbs()
    assert [len(limb.joints) for limb in (*limbs.legs.values(), *limbs.arms.values())] == [6, 6, 7, 7]
    assert limbs.head is not None
    assert len(limbs.head.joints) == 2
    _, found = adopt(spec)
    robot = RobotModel(found)
    feet = [footprint(robot, side) for side in SIDES]
    for side, foot in zip(SIDES, feet, strict=True):
        assert foot is not None
        np.testing.assert_allclose(found.legs[side].sole.position, foot.centre, atol=1e-3)


def test_names_that_yaml_takes_for_something_else_are_quoted(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    names = {"pelvis": "no", "head": "12", "left_foot": 'foot: left, "l"', "left_hand": "*hand #1"}
    for before, name in names.items():
        spec.body(before).name = name
    spec.body("right_foot").name = "foot😀"
    spec.joint("left_knee").name, spec.joint("right_knee").name = "null", "knee[right]"
    description, found = adopt(spec)
    assert (found.base, found.gaze.body) == ("no", "12")
    assert (found.legs["left"].sole.body, found.hands["left"].body) == (names["left_foot"], names["left_hand"])
    assert found.legs["right"].sole.body == "foot😀"
    robot = RobotModel(found)
    assert {robot.home_qpos[7 + robot.joint(name)] for name in ("null", "knee[right]")} == {0.7}
    assert formatted(description.text, "robot.yaml") == description.text


def test_a_pattern_that_another_one_holds_is_not_written(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in SIDES:
        spec.joint(f"{side}_hip_pitch").name = f"{side}_bend"
        spec.joint(f"{side}_ankle_pitch").name = f"{side}_ankle_bend"
    _, found = adopt(spec)
    assert [pattern for pattern in found.home if "bend" in pattern] == ["*_bend"]
    RobotModel(found)


def test_the_posture_bends_the_knees_and_lets_the_arms_hang_clear(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side, way in (("left", 1), ("right", -1)):  # a reference posture with the arms stretched out to the sides
        shoulder = spec.body(f"{side}_shoulder_pitch_link")
        shoulder.quat = [np.cos(np.pi / 4), np.sin(np.pi / 4) * way, 0, 0]
    for joint in spec.joints:
        if "shoulder_roll" in joint.name:
            joint.range = [-2.5, 2.5]
    _, found = adopt(spec)
    robot = RobotModel(found)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.home_qpos
    mujoco.mj_forward(robot.model, data)
    touching = {robot.model.body(robot.model.geom_bodyid[geom]).name for geom in data.contact.geom.ravel()}
    assert not [name for name in touching if any(part in name for part in ("hand", "arm", "wrist"))]
    for side, out in (("left", 1), ("right", -1)):
        palm, sole = data.site(palm_site(side)).xpos, data.site(sole_site(side)).xpos
        shoulder = data.body(f"{side}_shoulder_pitch_link").xpos
        assert palm[2] < shoulder[2] - 0.3
        assert out * palm[1] > out * shoulder[1]
        assert 0.0 < palm[0] - shoulder[0] < 0.3
        assert data.site(sole_site(side)).xmat[8] == pytest.approx(1.0, abs=1e-3)
        assert abs(sole[0] - data.body("pelvis").xpos[0]) < 0.1


def test_arms_hang_farther_out_beside_a_wide_trunk_of_several_shapes(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    spec.body("torso").add_geom(
        name="pack", type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.05, 0.13, 0.1], pos=[0, 0, 0.1], contype=1, conaffinity=1
    )
    model = spec.compile()
    _, found = adopt(spec)
    data = mujoco.MjData(model)
    data.qpos[:] = RobotModel(found).home_qpos
    mujoco.mj_forward(model, data)
    arm = Surveyor(model).limbs().arms["left"].joints[2:]
    shapes = [geom for geom in range(model.ngeom) if model.geom_bodyid[geom] in model.jnt_bodyid[list(arm)]]
    pack = model.geom("pack").id
    nearest = min(mujoco.mj_geomDistance(model, data, pack, geom, 1.0, None) for geom in shapes)
    assert nearest == pytest.approx(0.03, abs=0.005)


@pytest.mark.parametrize("ref", [0.5, -1.2])
def test_joints_count_from_where_the_model_has_their_zero(spec: mujoco.MjSpec, adopt: Adopt, ref: float) -> None:
    straight = adopt(spec)[1]
    wanted = poses(RobotModel(straight))
    for joint in spec.joints[1:]:
        joint.ref, joint.range = ref, joint.range + ref
    found = adopt(spec)[1]
    assert found.gait == straight.gait
    for joint in spec.joints[1:]:
        assert found.home_angle(joint.name) == pytest.approx(straight.home_angle(joint.name) + ref, abs=0.011)
    np.testing.assert_allclose(poses(RobotModel(found)), wanted, atol=0.01)


def test_arms_may_begin_with_collar_bones_in_the_middle(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side, out in (("left", 1), ("right", -1)):
        first = spec.body(f"{side}_shoulder_pitch_link")
        (second,) = first.bodies
        aside = np.array([0.0, out * 0.01 - first.pos[1], 0.0])
        first.pos, second.pos = first.pos + aside, second.pos - aside
    _, found = adopt(spec)
    assert (found.torso, set(found.hands)) == ("torso", {"left", "right"})


def test_arms_may_have_all_their_joints_in_one_link(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in SIDES:
        arm = spec.body(f"{side}_shoulder_pitch_link")
        spec.delete(*arm.bodies)
        for number, axis in enumerate(([1, 0, 0], [0, 0, 1])):
            arm.add_joint(name=f"{side}_{number}", axis=axis, range=[-1.5, 1.5])
        ends = [0, 0, 0, 0, 0, -0.4]
        arm.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.03, 0, 0], fromto=ends, contype=1, conaffinity=1)
    _, found = adopt(spec)
    assert {hand.body for hand in found.hands.values()} == {f"{side}_shoulder_pitch_link" for side in SIDES}
    assert all(np.isfinite(angle) for angle in found.home.values())


def test_a_robot_with_one_arm_has_one_hand(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    spec.delete(spec.body("right_shoulder_pitch_link"))
    description, found = adopt(spec)
    assert set(found.hands) == {"left"}
    assert found.torso == "torso"
    assert "no right arm: skills that command this hand will fail" in description.found
    assert "right_hand" not in found.resources


def test_a_robot_without_arms_has_a_torso_and_a_head(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in SIDES:
        spec.delete(spec.body(f"{side}_shoulder_pitch_link"))
    _, found = adopt(spec)
    assert not found.hands
    assert (found.torso, found.gaze.body, found.neck is None) == ("torso", "head", False)


def test_drives_that_the_model_says_nothing_of_are_as_strong_as_the_robot_is_heavy(
    spec: mujoco.MjSpec, adopt: Adopt
) -> None:
    _, light = adopt(spec)
    for body in spec.bodies:
        for geom in body.geoms:
            geom.mass *= 2
    description, heavy = adopt(spec)
    assert "stiffness, damping and torque of the drives" in description.guessed
    for joint, least in (("left_knee", 80), ("left_ankle_pitch", 40), ("left_hip_roll", 80)):
        drives = light.drive(joint), heavy.drive(joint)
        assert drives[0] is not None
        assert drives[1] is not None
        assert drives[0].torque > least
        assert drives[1].torque == pytest.approx(2 * drives[0].torque, rel=0.1)


def test_torques_that_no_drive_has_are_as_if_the_model_said_nothing(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    _, unsaid = adopt(spec)
    for joint in spec.joints[1:]:
        joint.actfrclimited, joint.actfrcrange = mujoco.mjtLimited.mjLIMITED_TRUE, [-1e9, 1e9]
    description, found = adopt(spec)
    assert found.drives == unsaid.drives
    assert "stiffness, damping and torque of the drives" in description.guessed


@pytest.mark.parametrize("gear", [1, -10])
def test_drives_are_those_of_the_models_actuators(spec: mujoco.MjSpec, adopt: Adopt, gear: int) -> None:
    for joint in spec.joints[1:]:
        drive = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.ctrllimited, drive.ctrlrange = True, [-60, 60]
    knee = spec.actuator("left_knee")
    knee.set_to_position(kp=321 / gear**2, kv=12 / gear**2)
    knee.gear[0] = gear
    knee.ctrllimited, knee.forcelimited, knee.forcerange = False, True, [-99 / abs(gear), 99 / abs(gear)]
    _, found = adopt(spec)
    left, right = (found.drive(f"{side}_knee") for side in SIDES)
    assert left is not None
    assert right is not None
    assert (left.stiffness, left.damping, left.torque) == (321, 12, 99)
    assert right.torque == 60


JOINT = 'joint="left_elbow"'


@pytest.mark.parametrize(
    ("actuators", "stiffness", "torque"),
    [
        ('<position jointinparent="left_elbow" kp="333" kv="11" forcerange="-77 77"/>', 333, 77),
        (f'<position {JOINT} kp="333" kv="11" forcerange="-60 140"/>', 333, 60),
        (f'<motor {JOINT} ctrlrange="-30 90"/>', 120, 30),
        (f'<general {JOINT} biastype="none" gainprm="77" biasprm="0 -200 -5" ctrlrange="-1 1"/>', 310, 77),
        (f'<motor {JOINT} ctrlrange="-40 40"/><motor {JOINT} ctrlrange="-40 40"/>', 320, 80),
        (f'<position {JOINT} kp="300" forcerange="-50 50"/><velocity {JOINT} kv="9"/>', 300, 50),
    ],
)
def test_actuators_are_read_as_mujoco_does(tmp_path: Path, actuators: str, stiffness: float, torque: float) -> None:
    text = (BUILTIN / "humanoid.xml").read_text()
    (tmp_path / "model.xml").write_text(text.replace("</mujoco>", f"<actuator>{actuators}</actuator></mujoco>"))
    (tmp_path / "robot.yaml").write_text(describe(read_model(tmp_path / "model.xml").compile(), "x", "model.xml").text)
    drive = load_robot_config(tmp_path / "robot.yaml").drive("left_elbow")
    assert drive is not None
    assert (drive.stiffness, drive.torque) == (stiffness, torque)


@pytest.mark.parametrize("names", [["finger_0", "finger_1"], ["part_0", "part_1"], ["gripper_joint"]])
def test_fingers_are_told_from_arms(spec: mujoco.MjSpec, adopt: Adopt, names: list[str]) -> None:
    for side in SIDES:
        hand = spec.body(f"{side}_hand")
        for name, y in zip(names, (-0.02, 0.02), strict=False):
            finger = hand.add_body(name=f"{side}_{name}", pos=[0, y, -0.15])
            finger.add_joint(name=f"{side}_{name}", axis=[0, 1, 0], range=[0, 1])
            finger.add_geom(type=mujoco.mjtGeom.mjGEOM_CAPSULE, size=[0.008, 0.02, 0], pos=[0, 0, -0.03], mass=0.05)
    description, found = adopt(spec)
    assert {side: found.hands[side].body for side in SIDES} == {side: f"{side}_hand" for side in SIDES}
    assert found.groups["left_fingers"] == [f"left_{name}" for name in names]
    assert f"left arm: 7 joints, {len(names)} of fingers, hand left_hand" in description.found


def test_an_ankle_without_roll_is_told_and_does_not_matter(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in SIDES:
        spec.delete(spec.joint(f"{side}_ankle_roll"))
    description, found = adopt(spec)
    assert description.missing == ()
    assert "left leg: 5 joints, foot left_ankle_link, none of them tilts it sideways" in description.found
    assert [found.legs[side].ankle_roll for side in SIDES] == [None, None]
    assert found.sole.bears[1] == 0.0
    RobotModel(found)


def test_legs_of_one_link_are_told_with_what_they_lack() -> None:
    leg = (
        '<body name="{0}" pos="0 {1} -0.1"><joint name="{0}" axis="0 1 0" range="-1 1"/>'
        '<geom type="capsule" fromto="0 0 0 0 0 -0.4" size="0.04"/>'
        '<geom size="0.1 0.04 0.01" type="box" pos="0 0 -0.42"/></body>'
    )
    legs = leg.format("left", 0.1) + leg.format("right", -0.1)
    model = f'<mujoco><worldbody><body name="base"><freejoint/><geom size="0.1"/>{legs}</body></worldbody></mujoco>'
    description = describe(mujoco.MjModel.from_xml_string(model), "found", "model.xml")
    assert {"hip_roll of the left leg", "ankle_pitch of the right leg"} <= set(description.missing)
    assert yaml.safe_load(description.text)["home"] == {}


def test_a_leg_without_another_joint_is_told(spec: mujoco.MjSpec) -> None:
    for side in SIDES:
        spec.delete(spec.joint(f"{side}_hip_roll"))
        spec.delete(spec.joint(f"{side}_ankle_roll"))
    description = describe(spec.compile(), "found", "model.xml")
    assert description.missing == ("hip_roll of the left leg", "hip_roll of the right leg")


@pytest.mark.parametrize(
    ("pattern", "says"),
    [
        ("left_wrist_yaw", "'left_wrist_yaw' has no limits: control turns it as far as it likes"),
        ("(left|right)_wrist_yaw", "'left_wrist_yaw' and 'right_wrist_yaw' have no limits: control turns them as "),
        (".*", "31 of 31 joints have no limits: control turns them as far as it likes"),
    ],
)
def test_joints_without_limits_are_told_once(spec: mujoco.MjSpec, pattern: str, says: str) -> None:
    for joint in spec.joints[1:]:
        if re.fullmatch(pattern, joint.name):
            joint.limited, joint.range = mujoco.mjtLimited.mjLIMITED_FALSE, [0, 0]
    description = describe(spec.compile(), "found", "model.xml")
    (missing,) = description.missing
    assert missing.startswith(f"limits in the model: {says}")
    assert f"# {says}" in description.text.partition("\nmodel:")[0]  # where a comment would allow it


def test_eyes_that_no_neck_turns_down_look_down(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    assert adopt(spec)[1].gaze.down == 0.0
    for name in ("neck_yaw", "neck_pitch"):
        spec.delete(spec.joint(name))
    stiff = adopt(spec)[1]  # its waist leans, but little for a learned walker
    assert 0.3 < stiff.gaze.down < 0.7
    robot = RobotModel(stiff)
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.home_qpos
    mujoco.mj_kinematics(robot.model, data)
    ahead = data.site(GAZE_SITE).xmat.reshape(3, 3)[:, 0]
    np.testing.assert_allclose(ahead, [np.cos(stiff.gaze.down), 0.0, -np.sin(stiff.gaze.down)], atol=1e-6)


def test_a_camera_that_is_a_link_of_its_own_on_the_head_is_where_the_eyes_are(
    spec: mujoco.MjSpec, adopt: Adopt
) -> None:
    spec.delete(spec.site("gaze"))
    spec.body("torso").add_body(name="chest_camera_link", pos=[0.1, 0, 0.2])
    assert "chest_camera_link" not in adopt(spec)[0].text
    spec.body("head").add_body(name="d435_link", pos=[0.07, 0.01, 0.11])
    description, found = adopt(spec)
    assert found.gaze.body == "head"
    assert found.gaze.position == pytest.approx((0.07, 0.01, 0.11))
    assert "# from the model's body 'd435_link'" in description.text


def turn(spec: mujoco.MjSpec, name: str, axis: list[float], angle: float) -> None:
    """Turn the frame of a body [rad] and leave all that is in it where it is, as a CAD might have it."""
    turned, back, body = np.zeros(4), np.zeros(4), spec.body(name)
    mujoco.mju_axisAngle2Quat(turned, np.array(axis) / np.linalg.norm(axis), angle)
    mujoco.mju_negQuat(back, turned)
    quat = np.zeros(4)
    mujoco.mju_mulQuat(quat, body.quat, turned)
    body.quat = quat
    for thing in (*body.geoms, *body.sites, *body.cameras, *body.bodies, *body.joints):
        place, own = np.zeros(3), np.zeros(3 if isinstance(thing, mujoco.MjsJoint) else 4)
        mujoco.mju_rotVecQuat(place, thing.pos, back)
        if isinstance(thing, mujoco.MjsJoint):
            mujoco.mju_rotVecQuat(own, thing.axis, back)
            thing.axis = own
        else:
            mujoco.mju_mulQuat(own, back, thing.quat)
            thing.quat = own
        thing.pos = place


def poses(robot: RobotModel) -> list[np.ndarray]:
    """Return how soles and eyes stand in the home posture."""
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.home_qpos
    mujoco.mj_kinematics(robot.model, data)
    sites = [data.site(name) for name in (GAZE_SITE, *map(sole_site, SIDES))]
    return [np.concatenate([site.xpos, site.xmat]) for site in sites]


def test_frames_of_feet_and_head_may_be_turned_as_cad_does(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    straight = adopt(spec)[1]
    wanted = poses(RobotModel(straight))
    for side in SIDES:
        turn(spec, f"{side}_foot", [0.3, 1.0, 0.2], 1.9)
    turn(spec, "head", [0.0, 1.0, 0.0], -0.7)
    description, turned = adopt(spec)
    assert description.missing == ()
    assert (turned.sole, turned.gait) == (straight.sole, straight.gait)
    for found, pose in zip(poses(RobotModel(turned)), wanted, strict=True):
        np.testing.assert_allclose(found, pose, atol=3e-3)


def test_a_foot_that_tilts_where_all_joints_are_zero_is_flat_at_home(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in SIDES:
        foot = spec.body(f"{side}_foot")
        foot.quat = [np.cos(0.15), 0.0, np.sin(0.15), 0.0]
    for pose in poses(RobotModel(adopt(spec)[1]))[1:]:
        assert pose[-1] > np.cos(0.06)


def test_the_gait_of_a_small_robot_is_smaller_and_quicker(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    usual = adopt(spec)[1].gait
    assert (usual.step_forward, usual.single_support) == (GaitConfig.step_forward, GaitConfig.single_support)
    for body in spec.bodies[1:]:
        body.pos = 0.5 * body.pos
        for geom in body.geoms:
            geom.pos, geom.size, geom.mass = 0.5 * geom.pos, 0.5 * geom.size, geom.mass / 8
            geom.fromto = 0.5 * geom.fromto
    small = adopt(spec)[1].gait
    assert small.step_forward == pytest.approx(usual.step_forward / 2, rel=0.1)
    assert small.double_support == pytest.approx(usual.double_support / 2**0.5, rel=0.1)
    assert small.tilt_stiffness == pytest.approx(usual.tilt_stiffness / 16, rel=0.1)
    assert small.rise == pytest.approx(usual.rise / 2, rel=0.1)
    assert small.separation_min >= 2 * 0.0225 - 0.005


def test_a_robot_of_a_few_hundred_grams_lands_by_its_own_weight(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    heavy = adopt(spec)[1].gait.touchdown_force
    for body in spec.bodies[1:]:
        for geom in body.geoms:
            geom.mass = geom.mass / 125 if geom.mass > 0 else geom.mass
    assert adopt(spec)[1].gait.touchdown_force == pytest.approx(heavy / 125, rel=0.05)


def scale(spec: mujoco.MjSpec, factor: float) -> None:
    """Multiply the lengths of a model and let its masses be."""
    for body in spec.bodies[1:]:
        body.pos = factor * body.pos
        for geom in body.geoms:
            geom.pos, geom.size, geom.fromto = factor * geom.pos, factor * geom.size, factor * geom.fromto


@pytest.mark.parametrize(("factor", "says"), [(1000, "1400 m"), (100, "140 m"), (0.001, "0.0014 m")])
def test_a_model_that_is_not_in_metres_is_refused(spec: mujoco.MjSpec, factor: float, says: str) -> None:
    scale(spec, factor)
    with pytest.raises(NoHumanoidError, match=rf"about {says} high, expected: 0.1 to 5 m; lengths .* in metres"):
        describe(spec.compile(), "found", "model.xml")


def test_what_counts_as_a_contact_goes_with_the_weight_of_a_heavy_robot(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    usual = adopt(spec)[1].contact
    assert usual == ContactConfig()
    for body in spec.bodies:
        for geom in body.geoms:
            geom.mass *= 2
    heavy = adopt(spec)[1].contact
    assert heavy.torso == pytest.approx(2 * usual.torso, rel=0.05)
    assert heavy.limit == pytest.approx(2 * usual.limit, rel=0.05)


def test_gains_with_which_nothing_stands_are_not_taken_for_the_robots(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    _, usual = adopt(spec)
    for joint in spec.joints[1:]:
        drive = spec.add_actuator(name=joint.name, target=joint.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        drive.set_to_position(kp=1, kv=0.1)
        drive.ctrllimited = False
    description, found = adopt(spec)
    assert any("stiffness" in line for line in description.guessed)
    knee, arm, wanted = found.drive("left_knee"), found.drive("left_elbow"), usual.drive("left_knee")
    assert knee is not None
    assert arm is not None
    assert wanted is not None
    assert (knee.stiffness, knee.damping) == (wanted.stiffness, wanted.damping)
    assert arm.stiffness == 1


def test_toes_belong_to_the_foot(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in SIDES:
        toes = spec.body(f"{side}_foot").add_body(name=f"{side}_toes", pos=[0.15, 0, -0.045])
        toes.add_joint(name=f"{side}_toes", axis=[0, 1, 0], range=[-1, 1])
        toes.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=[0.03, 0.04, 0.015], pos=[0.03, 0, 0], mass=0.05)
    _, found = adopt(spec)
    assert {leg.sole.body for leg in found.legs.values()} == {"left_foot", "right_foot"}
    assert {leg.ankle_pitch for leg in found.legs.values()} == {"left_ankle_pitch", "right_ankle_pitch"}


@pytest.mark.parametrize(("size", "says"), [([0.03, 0, 0], "at a point"), ([0.02, 0.08, 0], "at a line")])
def test_a_foot_that_is_not_flat_is_told(spec: mujoco.MjSpec, size: list[float], says: str) -> None:
    for side in SIDES:
        (foot,) = (geom for geom in spec.body(f"{side}_foot").geoms if geom.name)
        foot.type = mujoco.mjtGeom.mjGEOM_CAPSULE if size[1] else mujoco.mjtGeom.mjGEOM_SPHERE
        foot.size, foot.quat = size, [np.cos(np.pi / 4), 0, np.sin(np.pi / 4), 0]
    missing = describe(spec.compile(), "found", "model.xml").missing
    assert [says in line for line in missing] == [True, True]


def test_a_flat_foot_that_tilts_in_the_zero_pose_is_told_so(spec: mujoco.MjSpec) -> None:
    for side in SIDES:
        foot = spec.body(f"{side}_foot")
        spec.delete(next(geom for geom in foot.geoms if geom.name))
        for x, y in itertools.product((-0.07, 0.13), (-0.03, 0.03)):
            foot.add_geom(size=[0.005, 0, 0], pos=[x, y, -0.055], mass=0.1, contype=1)
    assert describe(spec.compile(), "found", "model.xml").missing == ()
    for side in SIDES:
        spec.body(f"{side}_shin").quat = [np.cos(0.5), 0, np.sin(0.5), 0]
    missing = describe(spec.compile(), "found", "model.xml").missing
    says = (
        r"as the model's zero pose has it, \w+ touches a floor at a line",
        r"legs must be straight there, and feet level$",
    )
    assert [all(re.search(part, line) for part in says) for line in missing] == [True, True]


def test_a_foot_that_only_pairs_let_touch_says_where_to_look(spec: mujoco.MjSpec) -> None:
    for side in SIDES:
        for geom in spec.body(f"{side}_foot").geoms:
            geom.contype = geom.conaffinity = 0
    missing = describe(spec.compile(), "found", "model.xml").missing
    assert all("if a scene file lets them touch a floor, name that file" in line for line in missing)


@pytest.mark.parametrize(("feet", "guessed"), [(("left",), False), (("left", "right"), True)])
def test_soles_that_were_not_found_are_asked_for_in_the_file(
    spec: mujoco.MjSpec, feet: tuple[Side, ...], guessed: bool
) -> None:
    for side in feet:
        for geom in spec.body(f"{side}_foot").geoms:
            geom.contype = geom.conaffinity = 0
    description = describe(spec.compile(), "found", "model.xml")
    comments = " ".join(line.strip() for line in description.text.splitlines()).replace(" # ", " ")
    for missing in description.missing:
        assert f"missing: {missing}" in comments
    assert len(description.missing) == len(feet)
    assert [line for line in description.guessed if "sole" in line] == ["the size of the soles"] * guessed
    (shape,) = (line for line in description.text.splitlines() if line.startswith("sole:"))
    assert ("guessed" in shape) == guessed


def test_a_robot_that_lies_in_its_frame_is_refused(spec: mujoco.MjSpec) -> None:
    pelvis = spec.body("pelvis")
    turn(spec, "pelvis", [1.0, 0.0, 0.0], np.pi / 2)
    assert pelvis.name == "pelvis"
    with pytest.raises(NoHumanoidError, match=r"no pair of feet below it|no leg is on the"):
        describe(spec.compile(), "found", "model.xml")


@pytest.mark.parametrize("place", ['pos="1 2 0.2" euler="0 1.5708 0.3"', 'pos="0 0 0.2" quat="1 0 0.3 0"'])
@pytest.mark.parametrize("frame", ['<frame euler="0.9 0 0" pos="3 0 0">', "<frame>"])
def test_how_a_base_is_turned_in_the_world_says_nothing(tmp_path: Path, place: str, frame: str) -> None:
    text = (BUILTIN / "humanoid.xml").read_text()
    own = describe(read_model(BUILTIN / "humanoid.xml").compile(), "found", "model.xml")
    assert 'pos="0 0 0.71"' in text
    text = text.replace('pos="0 0 0.71"', place).replace("<worldbody>", f"<worldbody>{frame}")
    (tmp_path / "model.xml").write_text(text.replace("</worldbody>", "</frame></worldbody>"))
    lying = read_model(tmp_path / "model.xml").compile()
    assert describe(lying, "found", "model.xml") == own
    np.testing.assert_array_equal(lying.qpos0[[0, 1, 3, 4, 5, 6]], [0, 0, 1, 0, 0, 0])


@pytest.mark.parametrize(("axis", "angle"), [((0, 1, 0), np.pi / 2), ((0, 1, 0), -np.pi / 2), ((1, 0, 0), np.pi)])
def test_a_robot_whose_arms_are_lowest_in_its_frame_is_refused(
    spec: mujoco.MjSpec, axis: tuple[float, ...], angle: float
) -> None:
    for side in SIDES:
        spec.body(f"{side}_forearm").quat = [np.cos(np.pi / 4), 0, -np.sin(np.pi / 4), 0]  # forearms ahead
    turn(spec, "pelvis", list(axis), angle)
    with pytest.raises(NoHumanoidError, match=r"no pair of feet below it: in its frame x must .* z up"):
        describe(spec.compile(), "found", "model.xml")


def test_four_legs_are_refused() -> None:
    legs = "".join(
        f'<body pos="{x} {y} 0"><joint axis="0 1 0"/><geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3"/></body>'
        for x, y in itertools.product((0.25, -0.25), (0.1, -0.1))
    )
    body = f'<freejoint/><geom type="box" size="0.3 0.1 0.05"/>{legs}'
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody><body>{body}</body></worldbody></mujoco>")
    with pytest.raises(NoHumanoidError, match="on two legs"):
        describe(model, "found", "model.xml")


def test_a_base_that_faces_backward_is_refused(spec: mujoco.MjSpec) -> None:
    turn(spec, "pelvis", [0.0, 0.0, 1.0], np.pi)
    with pytest.raises(NoHumanoidError) as refused:
        describe(spec.compile(), "found", "model.xml")
    says = (
        "'pelvis' faces backward: the knees fold ahead and the feet are longer behind the ankles; in its frame x must"
    )
    assert str(refused.value).startswith(says)


def test_knees_or_feet_alone_that_say_so_are_told(spec: mujoco.MjSpec, adopt: Adopt) -> None:
    for side in SIDES:
        spec.joint(f"{side}_knee").range = [-2.3, 0.0]
    knees = adopt(spec)[0]
    told = "that x of 'pelvis' points ahead, although "
    assert f"{told}the knees fold ahead" in knees.guessed
    assert "guessed: its x points ahead" in knees.text
    turn(spec, "pelvis", [0.0, 0.0, 1.0], np.pi)
    assert f"{told}the feet are longer behind the ankles" in adopt(spec)[0].guessed


@pytest.mark.parametrize(("change", "says"), [("no base", "one free joint"), ("no legs", "no leg is on the left")])
def test_what_is_no_humanoid_is_refused(spec: mujoco.MjSpec, change: str, says: str) -> None:
    if change == "no base":
        spec.delete(spec.joints[0])
    else:
        for name in ("left_hip_yaw_link", "left_shoulder_pitch_link"):
            spec.delete(spec.body(name))
    with pytest.raises(NoHumanoidError, match=says):
        describe(spec.compile(), "found", "model.xml")


def test_a_root_between_the_feet_is_told_with_what_is_to_be_the_root(tmp_path: Path) -> None:
    text = (BUILTIN / "humanoid.xml").read_text()
    root = '<body name="base_footprint"><body name="pelvis"'
    text = text.replace('<body name="pelvis"', root).replace('<freejoint name="root"/>', "")
    (tmp_path / "model.xml").write_text(text.replace("</worldbody>", "</body></worldbody>"))
    with pytest.raises(NoHumanoidError, match=r"'base_footprint', weighs nothing .* make 'pelvis', on it, the model's"):
        describe(read_model(tmp_path / "model.xml").compile(), "found", "model.xml")


@dataclass(frozen=True)
class Published:
    """What a published model has.

    Attributes:
        file: in the folder of published robots.
        torso, foot, hand: bodies; those of the left side.
        joints: of a leg, of an arm, and of the fingers of a hand.
    """

    file: str
    torso: str
    foot: str
    hand: str
    joints: tuple[int, int, int]


PUBLISHED = (
    Published("unitree_g1/g1.xml", "torso_link", "left_ankle_roll_link", "left_elbow_roll_link", (6, 5, 7)),
    Published("unitree_g1_29dof/g1_29dof.xml", "torso_link", "left_ankle_roll_link", "left_wrist_yaw_link", (6, 7, 0)),
    Published("unitree_h1/h1.xml", "torso_link", "left_ankle_link", "left_elbow_link", (5, 4, 0)),
    Published("booster_t1_29dof/t1_29dof.xml", "Trunk", "left_foot_link", "left_hand_link", (6, 7, 0)),
)


@pytest.mark.parametrize("robot", PUBLISHED, ids=lambda robot: robot.file.split("/")[0])
def test_limbs_of_published_robots_are_found(robot: Published) -> None:
    model = read_model(published_robot(robot.file)).compile()
    limbs = Surveyor(model).limbs()
    leg, arm = limbs.legs["left"], limbs.arms["left"]
    bodies = [model.body(body).name for body in (limbs.torso, leg.body, arm.body)]
    assert bodies == [robot.torso, robot.foot, robot.hand]
    assert (len(leg.joints), len(arm.joints), len(arm.fingers)) == robot.joints
    assert describe(model, "found", "model.xml").missing == ()
