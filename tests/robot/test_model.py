"""robot.yaml and the model it names: what they must say, and how mistakes are answered."""

from __future__ import annotations

import shutil
import struct
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.robot import mujoco_warnings
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import (
    BASE_COORDINATES,
    BASE_DOFS,
    GAZE_SITE,
    RobotModel,
    foot_sensor,
    palm_site,
    sole_site,
)
from humanoid_bt.robot.published import read_model
from tests.joint_ranges import write_joint_ranges

FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))  # of a tetrahedron
FOLDER = Path(__file__).resolve().parents[2] / "sim" / "humanoid"


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel(load_robot_config(FOLDER / "robot.yaml"))


Edit = Callable[[str, str, str], None]


@pytest.fixture
def edit(tmp_path: Path) -> Edit:
    """Change a copy of the built-in robot: file, old text, new text."""
    for file in ("robot.yaml", "humanoid.xml"):
        shutil.copy(FOLDER / file, tmp_path)

    def change(file: str, old: str, new: str) -> None:
        text = (tmp_path / file).read_text()
        assert old in text
        (tmp_path / file).write_text(text.replace(old, new, 1))

    return change


def load(folder: Path) -> RobotModel:
    return RobotModel(load_robot_config(folder / "robot.yaml"))


def place_of(folder: Path, file: str, text: str) -> str:
    """Return file:line:column of the first place where a text stands."""
    lines = (folder / file).read_text().splitlines()
    line = next(i for i, content in enumerate(lines) if text in content)
    return f"{folder / file}:{line + 1}:{lines[line].index(text) + 1}"


def test_joints_are_in_the_models_order(robot: RobotModel) -> None:
    model = robot.model
    for i, name in enumerate(robot.joint_names):
        joint = model.joint(name)
        assert joint.qposadr[0] == BASE_COORDINATES + i
        assert joint.dofadr[0] == BASE_DOFS + i
        assert robot.joint(name) == i
        assert model.actuator(i).name == name


def test_control_has_the_same_robot_without_what_is_only_drawn(robot: RobotModel) -> None:
    model, bare = robot.model, robot.bare
    assert bare.ngeom == (model.geom_contype | model.geom_conaffinity).astype(bool).sum() < model.ngeom
    forces = []
    for each in (model, bare):
        data = mujoco.MjData(each)
        data.qpos[:], data.qvel[:] = robot.home_qpos, np.linspace(-1, 1, each.nv)
        mujoco.mj_forward(each, data)
        forces.append(np.concatenate([data.qfrc_bias, data.qacc, data.site_xpos.ravel(), data.sensordata]))
    assert np.array_equal(*forces)


def test_numbers_of_the_drives_come_from_their_group(robot: RobotModel) -> None:
    knee, neck = robot.joint("right_knee"), robot.joint("neck_yaw")
    numbers = (robot.stiffness, robot.damping, robot.torque_limit, robot.speed_limit)
    assert [values[knee] for values in numbers] == [500, 20, 150, 12]
    assert [values[neck] for values in numbers] == [40, 2, 15, 12]


def test_soft_limits_lie_inside_the_models(robot: RobotModel) -> None:
    margin = robot.config.soft_limit_margin
    np.testing.assert_allclose(robot.lower, robot.model.jnt_range[1:, 0] + margin)
    np.testing.assert_allclose(robot.upper, robot.model.jnt_range[1:, 1] - margin)


def test_a_joint_that_hardly_turns_keeps_half_of_its_range(tmp_path: Path) -> None:
    robot = RobotModel(load_robot_config(write_joint_ranges(tmp_path, "left_wrist_roll", half=0.01)))
    wrist = robot.joint("left_wrist_roll")
    assert (robot.lower[wrist], robot.upper[wrist]) == pytest.approx((-0.005, 0.005))


def test_a_joint_without_a_range_has_no_soft_limits(tmp_path: Path) -> None:
    robot = RobotModel(load_robot_config(write_joint_ranges(tmp_path, "left_wrist_roll")))
    wrist = robot.joint("left_wrist_roll")
    assert (robot.lower[wrist], robot.upper[wrist]) == (-np.inf, np.inf)


def test_the_home_posture_is_inside_the_soft_limits(robot: RobotModel) -> None:
    home = robot.home_qpos[BASE_COORDINATES:]
    assert home[robot.joint("left_knee")] == 0.7
    assert home[robot.joint("right_shoulder_roll")] == -0.15
    assert home[robot.joint("neck_yaw")] == 0
    assert ((home >= robot.lower) & (home <= robot.upper)).all()


def test_sites_and_sensors_are_added(robot: RobotModel) -> None:
    for side in ("left", "right"):
        leg, hand = robot.config.legs[side], robot.config.hands[side]
        assert robot.model.body(robot.model.site(sole_site(side)).bodyid[0]).name == leg.sole.body
        np.testing.assert_allclose(robot.model.site(sole_site(side)).pos, leg.sole.position)
        np.testing.assert_allclose(robot.model.site(palm_site(side)).pos, hand.position)
        assert robot.model.sensor(foot_sensor(side)).dim[0] == 3
    np.testing.assert_allclose(robot.model.site(GAZE_SITE).pos, robot.config.gaze.position)
    assert robot.mass == pytest.approx(robot.model.body_mass.sum())


def test_a_published_models_own_drives_keyframes_and_sensors_do_not_disturb(tmp_path: Path, edit: Edit) -> None:
    own = (
        '<actuator><motor name="m" joint="left_knee" gear="50"/></actuator>'
        '<sensor><gyro site="imu"/><actuatorfrc actuator="m"/></sensor>'
        '<keyframe><key name="home" ctrl="1"/></keyframe></mujoco>'
    )
    edit("humanoid.xml", "</mujoco>", own)
    robot = load(tmp_path)
    assert robot.model.nu == len(robot.joint_names)
    assert robot.model.nkey == 0
    assert robot.model.nsensor == 2  # the feet's
    assert robot.model.actuator("left_knee").gainprm[0] == 1


def test_defaults_of_a_published_model_are_none_of_what_is_added(tmp_path: Path, edit: Edit) -> None:
    theirs = '<motor gear="50"/><general dyntype="filter" dynprm="0.5"/><site euler="1 1 1"/><default class="humanoid">'
    edit("humanoid.xml", '<default class="humanoid">', theirs)
    edit("humanoid.xml", '<site group="4" size="0.01"/>', '<site group="4" size="0.01" euler="1 1 1"/>')
    model = load(tmp_path).model
    assert (model.actuator_gear[:, 0] == 1).all()
    assert (model.actuator_dyntype == mujoco.mjtDyn.mjDYN_NONE).all()
    np.testing.assert_allclose(model.site(sole_site("left")).quat, [1, 0, 0, 0])
    np.testing.assert_allclose(model.site(palm_site("left")).quat, [1, 0, 0, 0])


def test_what_a_model_switches_off_is_on(tmp_path: Path, edit: Edit) -> None:
    flags = " ".join(f'{what}="disable"' for what in ("gravity", "contact", "actuation", "limit", "sensor"))
    world = f'gravity="0 0 0" density="1000" actuatorgroupdisable="0" iterations="1" o_margin="0.1"><flag {flags}'
    usual = load(tmp_path).model.opt
    edit("humanoid.xml", "<option ", f'<option {world} override="enable"/></option><option ')
    option = load(tmp_path).model.opt
    for key in ("disableflags", "enableflags", "disableactuator", "density", "iterations"):
        assert getattr(option, key) == getattr(usual, key)
    np.testing.assert_array_equal(option.gravity, [0, 0, -9.81])


def test_the_torque_limit_is_that_of_the_drive_whatever_the_models_joint_says(tmp_path: Path, edit: Edit) -> None:
    edit("humanoid.xml", '<joint name="left_elbow"', '<joint name="left_elbow" actuatorfrcrange="-3 3"')
    robot = load(tmp_path)
    data, elbow = mujoco.MjData(robot.model), robot.joint("left_elbow")
    data.ctrl[elbow] = 1e3
    mujoco.mj_forward(robot.model, data)
    assert data.qfrc_actuator[BASE_DOFS + elbow] == data.actuator_force[elbow] == robot.torque_limit[elbow] > 3


# ---- mistakes -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("old", "new", "message", "hint"),
    [
        ("torso: torso", "torso: torzo", "the model has no body 'torzo'", "did you mean 'torso'?"),
        ("base: pelvis", "base: pelvsi", "the model has no body 'pelvsi'", "did you mean 'pelvis'?"),
        ("torso: torso", "torso: world", "the model has no body 'world'", "torso"),
        (
            "hip_roll: left_hip_roll",
            "hip_roll: left_hip_rol",
            "no joint 'left_hip_rol'",
            "did you mean 'left_hip_roll'?",
        ),
        ("{body: left_hand,", "{body: lefthand,", "the model has no body 'lefthand'", "did you mean 'left_hand'?"),
        ("yaw: neck_yaw", "yaw: neckyaw", "the model has no joint 'neckyaw'", "did you mean 'neck_yaw'?"),
        ('"*_knee": 0.70', '"*_kneee": 0.70', "no joint of the model matches '*_kneee'", "left_knee"),
        ('torso: ["waist_*"', 'torso: ["waste_*"', "no joint of the model matches 'waste_*'", "waist_yaw"),
    ],
)
def test_an_unknown_name_is_answered_with_its_place_and_the_nearest_one(
    *, tmp_path: Path, edit: Edit, old: str, new: str, message: str, hint: str
) -> None:
    edit("robot.yaml", old, new)
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert message in problem.message
    assert hint in problem.hint
    wrong = problem.message.split("'")[1]
    line = place_of(tmp_path, "robot.yaml", wrong).rsplit(":", 1)[0]
    assert str(problem.place).startswith(line + ":")


@pytest.mark.parametrize(
    ("old", "new", "pattern"),
    [
        ('"*_knee": 0.70', '"*_knee*": 0.2\n  "*_knee": 0.70', '"*_knee": 0.70'),
        ("drives:  ", "drives:\n  - {joints: ['*_k*'], stiffness: 1, damping: 1, torque: 9}\n#", '"*_knee"], stiff'),
        ("groups:\n", "groups:\n  legs: ['*_hip_*', '*_knee', '*_ankle_*']\n", '"left_hip_*"'),
    ],
)
def test_a_pattern_that_counts_for_no_joint_is_refused(
    *, tmp_path: Path, edit: Edit, old: str, new: str, pattern: str
) -> None:
    edit("robot.yaml", old, new)
    with pytest.raises(UserError) as error:
        load(tmp_path)
    problem = error.value.problems[0]
    assert "counts for no joint: earlier ones match all that it matches" in problem.message
    line = place_of(tmp_path, "robot.yaml", pattern).rsplit(":", 1)[0]
    assert str(problem.place).startswith(line + ":")


def test_patterns_of_one_group_may_match_the_same_joints(tmp_path: Path, edit: Edit) -> None:
    edit("robot.yaml", '{joints: ["*_knee"],', '{joints: ["*_knee", left_knee],')
    load(tmp_path)


@pytest.mark.parametrize(
    ("old", "new", "body"),
    [("left: {body: left_hand,", "left: {body: torso,", "torso"), ("torso: torso", "torso: left_hand", "left_hand")],
)
def test_a_hand_that_no_arm_moves_is_refused(*, tmp_path: Path, edit: Edit, old: str, new: str, body: str) -> None:
    edit("robot.yaml", old, new)
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert problem.message.startswith(f"no joint moves the left hand, on {body!r}, against the torso")
    assert str(problem.place) == place_of(tmp_path, "robot.yaml", f"{body}, position")


def test_a_joint_without_a_drive_is_named(tmp_path: Path, edit: Edit) -> None:
    edit("robot.yaml", '  - {joints: ["neck_*"], stiffness: 40, damping: 2, torque: 15}\n', "")
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert problem.message == "no group in 'drives' matches 'neck_yaw', 'neck_pitch'"
    assert problem.place is not None
    assert problem.place.line > 1


def test_a_missing_model_file_is_named_where_it_is_asked_for(tmp_path: Path, edit: Edit) -> None:
    edit("robot.yaml", "model: humanoid.xml", "model: human.xml")
    with pytest.raises(UserError, match=r"the model file 'human.xml' is missing") as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert str(problem.place) == place_of(tmp_path, "robot.yaml", "human.xml")
    assert str(tmp_path / "human.xml") in problem.hint


def test_a_side_of_another_name_is_named(tmp_path: Path, edit: Edit) -> None:
    edit("robot.yaml", "  right: {body: right_hand", "  rigth: {body: right_hand")
    with pytest.raises(UserError, match="'hands' must have the keys left and right, or one of them"):
        load(tmp_path)


MISSING_MESH = (
    '<asset><mesh name="m" file="gone.stl"/></asset>'
    '<worldbody><geom type="mesh" mesh="m" contype="0" conaffinity="0"/></worldbody>'
)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("</mujoco>", "", "not a valid MJCF model"),
        ("<worldbody>", '<worldbody><geom typ="box"/>', "unrecognized attribute: 'typ'"),
        ("<worldbody>", f"{MISSING_MESH}<worldbody>", "gone.stl"),
    ],
)
def test_a_model_that_cannot_be_used_is_answered_with_the_models_name(
    *, tmp_path: Path, edit: Edit, old: str, new: str, message: str
) -> None:
    edit("humanoid.xml", old, new)
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert message in problem.message
    assert "\n" not in problem.message
    assert str(problem.place) == str(tmp_path / "humanoid.xml")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('<body name="head"', '<body name="head" gravcomp="1"', "gravcomp carries 'head', and the robot must carry"),
        ('<joint name="left_knee"', '<joint name="left_knee" type="slide"', "these joints are none: left_knee"),
        ('<joint name="left_knee"', '<joint name="left_knee" type="ball"', "these joints are none: left_knee"),
    ],
)
def test_what_no_robot_here_can_have_is_answered_with_its_line(
    *, tmp_path: Path, edit: Edit, old: str, new: str, message: str
) -> None:
    edit("humanoid.xml", old, new)
    place = place_of(tmp_path, "humanoid.xml", new)
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert message in problem.message
    assert str(problem.place) == f"{place.rsplit(':', 1)[0]}:1"


def test_a_path_that_mujoco_cannot_open_is_told(tmp_path: Path, edit: Edit) -> None:
    latin = tmp_path / "R\udcf6b\udcf6ter.xml"  # as Python has bytes of a name that are no UTF-8
    (tmp_path / "humanoid.xml").rename(latin)
    with pytest.raises(UserError, match="no model whose path is not in UTF-8"):
        read_model(latin)


def test_what_an_attached_model_brings_in_vain_is_told_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    monkeypatch.chdir(tmp_path)
    robot = f'<asset><model name="robot" file="{FOLDER / "humanoid.xml"}"/></asset>'
    world = '<worldbody><attach model="robot" body="pelvis" prefix="a/"/></worldbody>'
    Path("scene.xml").write_text(f"<mujoco>{robot}{world}</mujoco>")
    mujoco.set_mju_user_warning(None)
    read_model(Path("scene.xml")).compile()
    assert any("Attach conflict" in text for text in mujoco_warnings.taken())
    assert not recwarn.list
    assert not Path("MUJOCO_LOG.TXT").exists()


def test_a_rope_that_holds_the_robot_up_is_refused(tmp_path: Path, edit: Edit) -> None:
    edit("humanoid.xml", "<worldbody>", '<worldbody><site name="ceiling" pos="0 0 2"/>')
    rope = '<spatial name="rope" stiffness="5000"><site site="ceiling"/><site site="imu"/></spatial>'
    edit("humanoid.xml", "</worldbody>", f"</worldbody><tendon>{rope}</tendon>")
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert problem.message == "the tendon 'rope' ties the robot to the world, and it must stand by itself"


def test_a_base_on_joints_of_its_own_is_answered_with_what_to_do(tmp_path: Path, edit: Edit) -> None:
    slides = "".join(f'<joint name="base_{axis}" type="slide"/>' for axis in "xyz")
    edit("humanoid.xml", "<freejoint", f"{slides}<joint")
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = (problem for problem in error.value.problems if "can be driven" in problem.message)
    assert problem.message.endswith("these joints are none: base_x, base_y, base_z")
    assert "one <freejoint/> in the place of all of them" in problem.hint


def test_an_equality_constraint_is_answered_with_its_line_and_what_to_do(tmp_path: Path, edit: Edit) -> None:
    rod = '<connect name="rod" body1="left_shin" body2="left_foot" anchor="0 0 -0.3"/>'
    edit("humanoid.xml", "</mujoco>", f"<equality>\n{rod}\n</equality></mujoco>")
    with pytest.raises(UserError, match=r"the equality constraint 'rod' \(connect\)") as error:
        load(tmp_path)
    (problem,) = error.value.problems
    assert str(problem.place) == place_of(tmp_path, "humanoid.xml", rod)
    assert "take the rods out" in problem.hint


def test_many_equality_constraints_are_one_mistake(tmp_path: Path, edit: Edit) -> None:
    knees = '<joint joint1="left_knee"/><joint joint1="right_knee"/>'
    edit("humanoid.xml", "</mujoco>", f"<equality>{knees}</equality></mujoco>")
    with pytest.raises(
        UserError, match=r"2 equality constraints 'left_knee' \(joint\), 'right_knee' \(joint\)"
    ) as error:
        load(tmp_path)
    assert len(error.value.problems) == 1


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ('<body name="left_hip_roll_link">', "<body>", "body"),
        ('<body name="torso"', "<body", "body"),
        ('<body name="left_foot"', "<body", "body"),
        ('<body name="pelvis"', "<body", "body"),
        ('<joint name="left_hip_yaw"', "<joint", "joint"),
    ],
)
def test_what_has_no_name_is_answered_with_its_line(
    *, tmp_path: Path, edit: Edit, old: str, new: str, what: str
) -> None:
    for line in (FOLDER / "humanoid.xml").read_text().splitlines():
        if "<exclude" in line:
            edit("humanoid.xml", line, "")
    place = place_of(tmp_path, "humanoid.xml", old)
    edit("humanoid.xml", old, new)
    with pytest.raises(UserError) as error:
        load(tmp_path)
    (problem,) = (problem for problem in error.value.problems if "without a name" in problem.message)
    assert not [other for other in error.value.problems if "''" in other.message]
    assert problem.message.startswith(f"the model has a {what} without a name, on ")
    assert str(problem.place).rsplit(":", 1)[0] == place.rsplit(":", 1)[0]


TABLE = '<body name="table"><geom name="top" size="0.1"/><site name="edge"/></body>'


@pytest.mark.parametrize("place", ["<worldbody>", "</worldbody>"])
@pytest.mark.parametrize(
    ("world", "rest"),
    [
        ('<geom name="ground" type="plane" size="1 1 1"/>', ""),
        ('<light pos="0 0 3"/><camera name="above" pos="0 0 3" mode="targetbody" target="torso"/>', ""),
        ('<body name="goal" mocap="true"><geom size="0.1"/></body><body/>', ""),
        ('<body name="ball"><freejoint/><geom size="0.1"/></body>', '<keyframe><key time="1"/></keyframe>'),
        ('<body><joint axis="0 0 1"/><geom size="0.1"/></body>', ""),
        ('<body><joint type="slide"/><geom size="0.1"/></body>', ""),
        (f'{TABLE}<light mode="targetbody" target="table"/>', ""),
        ('<geom name="top" size="0.1"/>', '<sensor><distance geom1="top" geom2="left_foot"/></sensor>'),
        (TABLE, '<contact><exclude body1="table" body2="torso"/><pair geom1="top" geom2="left_foot"/></contact>'),
        (TABLE, '<equality><weld body1="table" body2="pelvis"/></equality>'),
        (TABLE, '<sensor><framepos objtype="body" objname="table" reftype="body" refname="torso"/></sensor>'),
        (TABLE, '<tendon><spatial><site site="edge"/><site site="imu"/></spatial></tendon>'),
    ],
)
def test_what_stands_in_the_world_beside_a_robot_is_left_out(
    *, tmp_path: Path, robot: RobotModel, edit: Edit, place: str, world: str, rest: str
) -> None:
    edit("humanoid.xml", place, f"{world}{place}" if "/" in place else f"{place}{world}")
    edit("humanoid.xml", "</mujoco>", f"{rest}</mujoco>")
    assert read_model(tmp_path / "humanoid.xml").compile().nsensor == 0
    model = load(tmp_path).model
    bodies = [[one.body(body).name for body in range(one.nbody)] for one in (model, robot.model)]
    assert bodies[0] == bodies[1]
    counts = [(one.nq, one.ngeom, one.nlight, one.ncam, one.nexclude, one.npair) for one in (model, robot.model)]
    assert counts[0] == counts[1]


def test_what_a_robot_carries_to_look_at_something_beside_it_is_left_out(tmp_path: Path, edit: Edit) -> None:
    eyes = '<camera name="eyes"/><camera mode="targetbody" target="table"/><light mode="targetbody" target="table"/>'
    edit("humanoid.xml", "<worldbody>", f"<worldbody>{TABLE}")
    edit("humanoid.xml", '<freejoint name="root"/>', f'<freejoint name="root"/>{eyes}')
    model = load(tmp_path).model
    assert (model.ncam, model.nlight) == (1, 0)


@pytest.mark.parametrize(
    "floor",
    [
        "",
        '<geom name="ground" type="plane" size="1 1 1"/>',
        '<body name="floor"><geom name="ground" type="plane" size="1 1 1"/></body>',
    ],
)
def test_a_foot_that_a_pair_lets_touch_a_floor_touches_any(tmp_path: Path, edit: Edit, floor: str) -> None:
    edit("humanoid.xml", '<geom name="left_foot"', '<geom contype="0" conaffinity="0" name="left_foot"')
    edit("humanoid.xml", "<worldbody>", f"<worldbody>{floor}")
    pair = '<pair geom1="left_foot" geom2="ground"/>'
    edit("humanoid.xml", "<contact>", f"<contact>{pair}")
    model = load(tmp_path).model
    assert model.geom("left_foot").contype == 1
    assert model.npair == 0


@pytest.mark.parametrize(("damping", "left"), [(0.7, 0.7), (30.0, 0.0)])
def test_damping_as_large_as_a_drives_is_that_of_the_dropped_actuator(
    tmp_path: Path, edit: Edit, damping: float, left: float
) -> None:
    edit("humanoid.xml", '<joint name="left_knee"', f'<joint damping="{damping}" name="left_knee"')
    model = load(tmp_path).model
    assert float(model.joint("left_knee").damping[0]) == left


def test_a_root_that_nothing_frees_gets_a_free_joint(tmp_path: Path, edit: Edit) -> None:
    edit("humanoid.xml", '<freejoint name="root"/>', "")
    model = load(tmp_path).model
    assert model.jnt_type[0] == mujoco.mjtJoint.mjJNT_FREE
    assert model.body(model.jnt_bodyid[0]).name == "pelvis"


BLOCK = """<robot name="one"><link name="base"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<collision><geometry><mesh filename="package://one/meshes/block.stl"/></geometry></collision></link></robot>"""


@pytest.mark.parametrize("urdf", ["one/urdf/one.urdf", "described/urdf/one.urdf"])
def test_meshes_of_a_package_are_found_above_and_beside_a_urdf(tmp_path: Path, urdf: str) -> None:
    corners = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))
    faces = [struct.pack("<12fH", *np.ravel([(0, 0, 0), *(corners[i] for i in face)]), 0) for face in FACES]
    (tmp_path / "one" / "meshes").mkdir(parents=True)
    (tmp_path / "one" / "meshes" / "block.stl").write_bytes(bytes(80) + struct.pack("<I", 4) + b"".join(faces))
    file = tmp_path / urdf
    file.parent.mkdir(parents=True)
    file.write_text(BLOCK)
    assert read_model(file).compile().nmesh == 1


def test_meshes_of_a_package_that_is_elsewhere_are_missed_by_name(tmp_path: Path) -> None:
    (tmp_path / "one.urdf").write_text(BLOCK)
    with pytest.raises(UserError, match=r"there is no 'package://one/meshes/block\.stl'") as error:
        read_model(tmp_path / "one.urdf")
    assert "folders named 'one'" in error.value.problems[0].hint


def test_meshes_that_mujoco_does_not_read_are_told_with_what_to_make_of_them(tmp_path: Path) -> None:
    (tmp_path / "one.urdf").write_text(BLOCK.replace(".stl", ".DAE"))
    with pytest.raises(UserError, match=r"1 mesh is a \.dae file, which MuJoCo does not read") as error:
        read_model(tmp_path / "one.urdf")
    assert ".stl or .obj" in error.value.problems[0].hint


def test_a_model_that_has_a_name_of_what_is_added_is_refused(tmp_path: Path, edit: Edit) -> None:
    edit("humanoid.xml", '<freejoint name="root"/>', f'<freejoint name="root"/><site name="{GAZE_SITE}"/>')
    with pytest.raises(UserError, match=f"the model has sites that are added to it: {GAZE_SITE}"):
        load(tmp_path)


def test_links_that_overlap_do_not_touch(tmp_path: Path, edit: Edit) -> None:
    edit("humanoid.xml", '<exclude body1="pelvis" body2="torso"/>', "")
    count = load(tmp_path).model.nexclude
    edit("robot.yaml", "gait:", "collision: {overlap: {pelvis: [torso]}}\ngait:")
    assert load(tmp_path).model.nexclude == count + 1
    edit("robot.yaml", "pelvis: [torso]", "pelvis: [torse]")
    with pytest.raises(UserError, match="the model has no body 'torse'") as error:
        load(tmp_path)
    assert str(error.value.problems[0].place) == place_of(tmp_path, "robot.yaml", "torse]")


def test_a_urdf_with_two_joints_of_one_name_is_refused(tmp_path: Path) -> None:
    shape = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    links = "".join(f'<link name="{name}">{shape}</link>' for name in ("trunk", "left_leg", "right_leg"))
    joints = "".join(
        f'<joint name="hip" type="continuous"><parent link="trunk"/><child link="{side}_leg"/></joint>'
        for side in ("left", "right")
    )
    (tmp_path / "one.urdf").write_text(f'<robot name="one">{links}{joints}</robot>')
    with pytest.raises(UserError, match=r"one\.urdf: error: not a valid URDF model: .*repeated name 'hip' in joint"):
        read_model(tmp_path / "one.urdf")


def test_a_urdf_keeps_its_root_and_is_free(tmp_path: Path) -> None:
    inertial = '<inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    (tmp_path / "robot.urdf").write_text(
        f'<robot name="r"><link name="base">{inertial.format(5)}</link><link name="leg">{inertial.format(2)}</link>'
        '<joint name="hip" type="revolute"><parent link="base"/><child link="leg"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" effort="30" velocity="1"/></joint></robot>'
    )
    model = read_model(tmp_path / "robot.urdf").compile()
    assert [int(kind) for kind in model.jnt_type] == [mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_HINGE]
    assert float(model.body("base").subtreemass[0]) == 7


def test_the_base_must_be_what_floats(tmp_path: Path, edit: Edit) -> None:
    edit("robot.yaml", "base: pelvis", "base: torso")
    with pytest.raises(UserError) as error:
        load(tmp_path)
    problem = error.value.problems[0]
    assert "exactly one free joint, on the base 'torso'" in problem.message
    assert str(problem.place) == place_of(tmp_path, "robot.yaml", "torso")


def test_every_mistake_is_told_at_once(tmp_path: Path, edit: Edit) -> None:
    edit("robot.yaml", "torso: torso", "torso: torzo")
    edit("robot.yaml", '"*_knee": 0.70', '"*_kneee": 0.70')
    edit("humanoid.xml", "</mujoco>", '<equality><weld body1="pelvis"/></equality></mujoco>')
    with pytest.raises(UserError) as error:
        load(tmp_path)
    assert len(error.value.problems) == 3


def test_the_built_in_model_is_not_changed_by_compiling(robot: RobotModel) -> None:
    again = robot.spec().compile()
    for name in ("body_mass", "jnt_range", "actuator_forcerange", "qpos0"):
        np.testing.assert_array_equal(getattr(again, name), getattr(robot.model, name))
    assert isinstance(robot.spec(), mujoco.MjSpec)
