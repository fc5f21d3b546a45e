"""The project's own humanoid: what the engine and its users rely on."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

MODEL = Path(__file__).resolve().parents[2] / "sim" / "humanoid" / "humanoid.xml"

LEG = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle_pitch", "ankle_roll")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_yaw", "wrist_pitch", "wrist_roll")
TRUNK = ("waist_yaw", "waist_roll", "waist_pitch", "neck_yaw", "neck_pitch")
JOINTS = {f"{side}_{joint}" for side in ("left", "right") for joint in LEG + ARM} | set(TRUNK)


@pytest.fixture(scope="module")
def model() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(MODEL))


@pytest.fixture
def data(model: mujoco.MjModel) -> mujoco.MjData:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    return data


def bend(model: mujoco.MjModel, data: mujoco.MjData, **angles: float) -> None:
    for joint, angle in angles.items():
        data.qpos[model.joint(joint).qposadr[0]] = angle
    mujoco.mj_forward(model, data)


def touching(model: mujoco.MjModel, data: mujoco.MjData) -> set[frozenset[str]]:
    return {frozenset(model.geom(geom).name for geom in contact.geom) for contact in data.contact}


def test_it_has_the_joints_that_control_is_written_for(model: mujoco.MjModel) -> None:
    names = {model.joint(i).name for i in range(model.njnt)}
    assert names == JOINTS | {"root"}


def test_the_base_is_free_and_nothing_holds_the_robot(model: mujoco.MjModel) -> None:
    assert model.joint("root").type[0] == mujoco.mjtJoint.mjJNT_FREE
    assert model.jnt_bodyid[model.joint("root").id] == model.body("pelvis").id
    assert model.neq == 0
    assert model.nmocap == 0
    assert model.ntendon == 0
    assert not model.body_gravcomp.any()
    assert model.nu == 0


def test_mass_and_height_are_those_of_a_small_person(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    mass = model.body("pelvis").subtreemass[0]
    assert 35 < mass < 45
    sole = data.site("left_sole").xpos[2]
    head = data.geom("head").xpos[2] + model.geom("head").size[0]
    assert sole == pytest.approx(0, abs=1e-6)
    assert 1.25 < head - sole < 1.4


@pytest.mark.parametrize("site", ["left_sole", "right_sole", "left_palm", "right_palm", "imu", "gaze"])
def test_sites_look_forward_when_all_joints_are_at_zero(data: mujoco.MjData, site: str) -> None:
    np.testing.assert_allclose(data.site(site).xmat, np.eye(3).ravel(), atol=1e-9)


def test_both_sides_mirror_each_other(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    for i in range(model.nbody):
        name = model.body(i).name
        if not name.startswith("left_"):
            continue
        left, right = model.body(name), model.body(name.replace("left_", "right_"))
        np.testing.assert_allclose(left.mass, right.mass)
        np.testing.assert_allclose(left.inertia, right.inertia)
        np.testing.assert_allclose(data.body(left.id).xpos, data.body(right.id).xpos * [1, -1, 1], atol=1e-9)
        np.testing.assert_allclose(data.body(left.id).xipos, data.body(right.id).xipos * [1, -1, 1], atol=1e-9)


@pytest.mark.parametrize("joint", LEG + ARM)
def test_ranges_mirror_each_other(model: mujoco.MjModel, joint: str) -> None:
    low, high = model.joint(f"left_{joint}").range
    turns_with_the_side = abs(model.joint(f"left_{joint}").axis[1]) < 0.5  # yaw and roll
    mirrored = (-high, -low) if turns_with_the_side else (low, high)
    np.testing.assert_allclose(model.joint(f"right_{joint}").range, mirrored)


def test_every_joint_is_limited_around_zero(model: mujoco.MjModel) -> None:
    for name in JOINTS:
        joint = model.joint(name)
        assert model.jnt_limited[joint.id], name
        low, high = joint.range
        assert -np.pi < low <= 0 <= high < np.pi, name
        assert high - low > 0.8, name


def test_all_joints_at_zero_is_free_of_self_contact(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    assert not touching(model, data)


@pytest.mark.parametrize(
    ("angles", "pair"),
    [
        ({"left_hip_roll": -0.4, "right_hip_roll": 0.4}, {"left_shin", "right_shin"}),
        ({"left_shoulder_roll": -0.3}, {"left_upper_arm", "torso"}),
        ({"right_shoulder_pitch": -1.2, "right_shoulder_roll": 0.3, "right_shoulder_yaw": 1.5, "right_elbow": -2.3},
         {"right_hand", "torso"}),
        ({"left_shoulder_roll": -0.1, "left_hip_roll": 0.2}, {"left_hand", "left_thigh"}),
    ],
)  # fmt: skip
def test_limbs_do_not_pass_through_the_body(
    model: mujoco.MjModel, data: mujoco.MjData, angles: dict[str, float], pair: set[str]
) -> None:
    bend(model, data, **angles)
    assert frozenset(pair) in touching(model, data)


def test_only_collision_shapes_touch_and_only_they_and_the_drives_weigh(model: mujoco.MjModel) -> None:
    for i in range(model.ngeom):
        touches = bool(model.geom_contype[i] or model.geom_conaffinity[i])
        assert touches == (model.geom_group[i] == 3), i
        assert touches == bool(model.geom(i).name), i


def test_a_palm_reaches_half_a_meter_ahead_of_the_shoulder(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    bend(model, data, left_shoulder_pitch=-np.pi / 2)
    reach = data.site("left_palm").xpos - data.body("left_upper_arm").xpos
    np.testing.assert_allclose(reach, [0.56, 0, 0], atol=1e-6)


def test_the_gaze_follows_the_neck(model: mujoco.MjModel, data: mujoco.MjData) -> None:
    bend(model, data, neck_yaw=np.pi / 4, neck_pitch=0.3)
    ahead = data.site("gaze").xmat.reshape(3, 3)[:, 0]
    assert ahead[0] == pytest.approx(ahead[1])
    assert ahead[2] == pytest.approx(-np.sin(0.3))


def test_the_soles_carry_it_on_a_floor() -> None:
    spec = mujoco.MjSpec.from_file(str(MODEL))
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 0.1], contype=1, conaffinity=1)
    for joint in spec.joints:  # stiff joints: all that is asked here is that the feet carry the weight
        if joint.name != "root":
            joint.stiffness[0] = 2000
            joint.damping[0] = 50
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 300)
    assert touching(model, data) == {frozenset({"floor", "left_foot"}), frozenset({"floor", "right_foot"})}
    force = sum(data.efc_force[contact.efc_address : contact.efc_address + 6].sum() for contact in data.contact)
    assert force == pytest.approx(model.body("pelvis").subtreemass[0] * 9.81, rel=0.05)
    assert data.site("left_sole").xpos[2] > -0.002
