from __future__ import annotations

from copy import copy
from dataclasses import replace
from pathlib import Path
from shutil import copytree

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.feedforward import Feedforward
from humanoid_bt.control.body.stabilizer import Load
from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.core.messages import SIDES, Array, Estimate, JointCommand
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel
from tests.control.conftest import ROBOT
from tests.control.control_rig import ControlRig


@pytest.fixture
def dynamics(robot: RobotModel, estimate: Estimate) -> RobotDynamics:
    dynamics = RobotDynamics(robot)
    dynamics.update(estimate)
    return dynamics


def standing_load(robot: RobotModel, dynamics: RobotDynamics, left: float = 0.5) -> Load:
    cop = np.array([(dynamics.com[0], dynamics.soles[side][1]) for side in SIDES])
    share = np.array([left, 1 - left])
    return Load(share, cop, share @ cop, np.array([0, 0, robot.mass * GRAVITY]))


def torques(
    robot: RobotModel,
    dynamics: RobotDynamics,
    load: Load,
    position: Array | None = None,
    acceleration: Array | None = None,
    tilt: tuple[float, float] = (0.0, 0.0),
) -> Array:
    joints = dynamics.data.qpos[BASE_COORDINATES:].copy()
    still = np.zeros(robot.model.nv)
    feedforward = Feedforward(robot, dynamics)
    wanted = joints if position is None else position
    return feedforward.torques(load, still if acceleration is None else acceleration, wanted, still[BASE_DOFS:], tilt)


def test_the_robot_stands_almost_still_on_feedforward_alone(
    rig: ControlRig, robot: RobotModel, dynamics: RobotDynamics, standing: Array
) -> None:
    torque = torques(robot, dynamics, standing_load(robot, dynamics))
    sag = {}
    for name, feedforward in (("with", torque), ("without", np.zeros_like(torque))):
        rig.reset()
        joints = standing[BASE_COORDINATES:]
        command = JointCommand(joints, np.zeros_like(joints), robot.stiffness, robot.damping, feedforward)
        for _ in range(300):
            rig.plant.step(command)
        sag[name] = np.abs(rig.plant.data.qpos[BASE_COORDINATES:] - joints).max()
    assert sag["with"] < 2e-3
    assert sag["without"] > 20 * sag["with"]


def test_the_ground_carries_the_whole_weight(robot: RobotModel, dynamics: RobotDynamics) -> None:
    """With the feet's forces the base needs no force of its own, or else the joints would not get the right torques."""
    load = standing_load(robot, dynamics)
    forces, jacobian = dynamics.bias.copy(), np.zeros((3, robot.model.nv))
    for side, share, cop in zip(SIDES, load.share, load.cop, strict=True):
        foot = robot.model.body(robot.config.legs[side].sole.body).id
        mujoco.mj_jac(robot.model, dynamics.data, jacobian, None, np.array([*cop, 0.0]), foot)
        forces -= jacobian.T @ (share * load.force)
    np.testing.assert_allclose(forces[:BASE_DOFS], np.zeros(BASE_DOFS), atol=0.1)
    np.testing.assert_allclose(torques(robot, dynamics, load), forces[BASE_DOFS:], atol=0.5)


def test_arms_are_held_against_gravity(robot: RobotModel, dynamics: RobotDynamics) -> None:
    torque = torques(robot, dynamics, standing_load(robot, dynamics))
    elbow = robot.joint("left_elbow")
    assert torque[elbow] == pytest.approx(dynamics.bias[BASE_DOFS + elbow])


def test_joints_are_held_against_their_springs(robot: RobotModel, estimate: Estimate) -> None:
    sprung, elbow = copy(robot), robot.joint("left_elbow")
    sprung.bare = copy(robot.bare)
    sprung.bare.jnt_stiffness[1 + elbow], sprung.bare.qpos_spring[BASE_COORDINATES + elbow] = 10.0, 0.5
    held = []
    for one in (robot, sprung):
        dynamics = RobotDynamics(one)
        dynamics.update(estimate)
        held.append(torques(one, dynamics, standing_load(one, dynamics)))
    expected = np.zeros(len(held[0]))
    expected[elbow] = 10.0 * (estimate.qpos[BASE_COORDINATES + elbow] - 0.5)
    np.testing.assert_allclose(held[1] - held[0], expected, atol=1e-9)


def test_the_leg_that_carries_more_pushes_more(robot: RobotModel, dynamics: RobotDynamics) -> None:
    torque = torques(robot, dynamics, standing_load(robot, dynamics, left=0.8))
    assert abs(torque[robot.joint("left_knee")]) > 2 * abs(torque[robot.joint("right_knee")])


def test_planned_acceleration_adds_inertia(robot: RobotModel, dynamics: RobotDynamics) -> None:
    load = standing_load(robot, dynamics)
    acceleration = np.zeros(robot.model.nv)
    elbow = robot.joint("left_elbow")
    acceleration[BASE_DOFS + elbow] = 10.0
    more = torques(robot, dynamics, load, acceleration=acceleration) - torques(robot, dynamics, load)
    expected = np.zeros(robot.model.nv)
    mujoco.mj_mulM(dynamics.model, dynamics.data, expected, acceleration)
    assert more[elbow] == pytest.approx(expected[BASE_DOFS + elbow])
    assert more[elbow] > 0


def test_stance_hips_resist_a_tilt_by_their_share(robot: RobotModel, estimate: Estimate) -> None:
    upright, leaning = RobotDynamics(robot), RobotDynamics(robot)
    upright.update(estimate)
    leaning.update(estimate)
    leaning.pitch += 0.1  # the tilt alone, with everything else as it was
    load = standing_load(robot, upright, left=0.75)
    more = torques(robot, leaning, load) - torques(robot, upright, load)
    tilt = robot.config.gait.tilt_stiffness * 0.1
    assert more[robot.joint("left_hip_pitch")] == pytest.approx(0.75 * tilt)
    assert more[robot.joint("right_hip_pitch")] == pytest.approx(0.25 * tilt)
    assert more[robot.joint("left_knee")] == pytest.approx(0)


def test_stance_hips_do_not_resist_a_tilt_that_is_meant(robot: RobotModel, estimate: Estimate) -> None:
    upright, leaning = RobotDynamics(robot), RobotDynamics(robot)
    upright.update(estimate)
    leaning.update(estimate)
    leaning.roll, leaning.pitch = leaning.roll - 0.05, leaning.pitch + 0.1
    load = standing_load(robot, upright, left=0.75)
    meant, off = torques(robot, leaning, load, tilt=(-0.05, 0.1)), torques(robot, leaning, load)
    np.testing.assert_allclose(meant, torques(robot, upright, load), atol=1e-9)
    assert np.abs(off - meant).max() > 10


def test_a_hip_that_turns_the_other_way_round_resists_a_tilt_the_same(tmp_path: Path) -> None:
    """Its torque has the other sign."""
    resists = []
    for axis in ("1 0 0", "-1 0 0"):
        folder = copytree(ROBOT.parent, tmp_path / axis)
        model = folder / "humanoid.xml"
        text = model.read_text()
        joint = 'name="left_hip_roll" axis="{}"'
        assert joint.format("1 0 0") in text
        model.write_text(text.replace(joint.format("1 0 0"), joint.format(axis)))
        robot = RobotModel(load_robot_config(folder / "robot.yaml"))
        upright, leaning = RobotDynamics(robot), RobotDynamics(robot)
        joints = np.zeros(len(robot.joint_names))
        for dynamics in (upright, leaning):
            at_rest = np.zeros(BASE_DOFS + len(joints))
            dynamics.update(Estimate(0.0, robot.home_qpos, at_rest, joints, np.zeros(2)))
        leaning.roll += 0.1
        load = standing_load(robot, upright)
        more = torques(robot, leaning, load) - torques(robot, upright, load)
        resists.append(more[robot.joint("left_hip_roll")])
    assert resists[0] > 0
    assert resists[1] == pytest.approx(-resists[0])


@pytest.mark.parametrize("sign", [1, -1])
def test_the_ankle_never_turns_the_foot_over_its_edge(robot: RobotModel, dynamics: RobotDynamics, sign: int) -> None:
    load = standing_load(robot, dynamics)
    weight = load.force[2] / 2
    sole = robot.config.sole
    joints = dynamics.data.qpos[BASE_COORDINATES:]
    for name, half in (("left_ankle_pitch", sole.half_length), ("right_ankle_roll", sole.half_width)):
        ankle = robot.joint(name)
        far = joints.copy()
        far[ankle] += sign * 1.0
        whole = torques(robot, dynamics, load, far)[ankle] + robot.stiffness[ankle] * sign
        height = 0.06 * weight * 0.5  # the ankle is not over the sole's centre
        assert abs(whole) <= weight * half + height


def test_the_sides_of_a_sole_have_a_margin_of_their_own(robot: RobotModel, dynamics: RobotDynamics) -> None:
    sole = robot.config.sole
    shorter = copy(robot)
    shorter.config = replace(robot.config, sole=replace(sole, margin=sole.margin + 0.04, side_margin=sole.margin))
    load = standing_load(robot, dynamics)
    weight = load.force[2] / 2
    for name, less in (("left_ankle_pitch", 0.02 * weight), ("right_ankle_roll", 0.0)):
        ankle = robot.joint(name)
        far = dynamics.data.qpos[BASE_COORDINATES:].copy()
        far[ankle] += 1.0
        torque = torques(robot, dynamics, load, far)[ankle] - torques(shorter, dynamics, load, far)[ankle]
        assert torque == pytest.approx(less, abs=0.05)


def test_an_unloaded_foot_has_no_ankle_limit(robot: RobotModel, dynamics: RobotDynamics) -> None:
    load = standing_load(robot, dynamics, left=1.0)
    ankle = robot.joint("right_ankle_pitch")
    far = dynamics.data.qpos[BASE_COORDINATES:].copy()
    near = torques(robot, dynamics, load, far.copy())
    far[ankle] += 1.0
    assert torques(robot, dynamics, load, far)[ankle] == pytest.approx(near[ankle])


def test_dynamics_measure_tilt_and_centre_of_mass(robot: RobotModel, estimate: Estimate) -> None:
    dynamics = RobotDynamics(robot)
    qpos = estimate.qpos.copy()
    qpos[3:7] = [np.cos(0.05), 0, np.sin(0.05), 0]
    qvel = estimate.qvel.copy()
    qvel[0] = 0.3
    dynamics.update(replace(estimate, qpos=qpos, qvel=qvel))
    assert dynamics.pitch == pytest.approx(0.1)
    assert dynamics.roll == pytest.approx(0)
    np.testing.assert_allclose(dynamics.com_velocity, [0.3, 0, 0], atol=1e-9)


@pytest.mark.parametrize(("roll", "pitch"), [(0.1, 0.0), (0.0, 0.1)])
def test_a_foot_that_no_joint_rolls_says_nothing_of_a_ground_that_leans_sideways(
    robot: RobotModel, line_feet: RobotModel, roll: float, pitch: float
) -> None:
    for model, counts in ((robot, roll), (line_feet, 0.0)):
        posture = standing_posture(model)
        joints = len(model.joint_names)
        qpos = posture.copy()
        turn = np.array([1.0, roll / 2, pitch / 2, 0.0])
        qpos[3:7] = turn / np.linalg.norm(turn)
        dynamics = RobotDynamics(model)
        dynamics.update(Estimate(0.0, qpos, np.zeros(6 + joints), np.zeros(joints), np.zeros(2)))
        for foot, side in enumerate(SIDES):
            np.testing.assert_allclose(dynamics.footings[side][1:], [counts, pitch], atol=2e-3)
            np.testing.assert_allclose(dynamics.sole_tilt(foot), [counts, pitch, 0.0], atol=2e-3)
