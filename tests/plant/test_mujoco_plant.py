"""The simulated plant: drives, sensors, pushes, and that it is the same every time."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig, StartConfig, load_scene
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, GAZE_SITE, RobotModel, sole_site
from tests.plant.drives import given
from tests.sensors import exact

SIM = Path(__file__).resolve().parents[2] / "sim"


@pytest.fixture(scope="module")
def robot() -> RobotModel:
    return RobotModel(exact(load_robot_config(SIM / "humanoid" / "robot.yaml")))


def scene(position: tuple[float, float] = (0.0, 0.0), heading: float = 0.0) -> Scene:
    return Scene(SceneConfig(format=1, name="empty", robot=StartConfig(position=position, heading=heading)), 0)


@pytest.fixture
def upright(robot: RobotModel) -> Array:
    """The home posture with the soles on the ground and between them the origin, shape (7 + nj,)."""
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.home_qpos
    mujoco.mj_kinematics(robot.model, data)
    soles = [data.site(sole_site(side)).xpos for side in ("left", "right")]
    qpos = robot.home_qpos.copy()
    qpos[:3] -= 0.5 * (soles[0] + soles[1])
    return qpos


@pytest.fixture
def plant(robot: RobotModel, upright: Array) -> MujocoPlant:
    plant = MujocoPlant(robot, scene())
    plant.place(upright)
    return plant


def hold(robot: RobotModel, joints: Array, stiffness: float = 3.0) -> JointCommand:
    """Hold a posture with stiffer drives than the robot's own: without balance control the ankles must not give."""
    zeros = np.zeros_like(joints)
    return JointCommand(joints, zeros, stiffness * robot.stiffness, stiffness * robot.damping, zeros)


# ---- drives ---------------------------------------------------------------------------------------------------------


def test_a_joint_command_is_the_torque_that_its_formula_says(plant: MujocoPlant, robot: RobotModel) -> None:
    numbers = np.random.default_rng(0)
    joints = len(robot.joint_names)
    for _ in range(20):
        before = plant.measure()
        command = JointCommand(
            position=before.joint_position + numbers.uniform(-0.02, 0.02, joints),
            velocity=numbers.uniform(-0.2, 0.2, joints),
            stiffness=numbers.uniform(0, 1, joints) * robot.stiffness,
            damping=numbers.uniform(0, 1, joints) * robot.damping,
            torque=numbers.uniform(-2, 2, joints),
        )
        plant.step(command)
        after = plant.measure()
        expected = given(command, before, after, robot.torque_limit)
        np.testing.assert_allclose(after.joint_torque, expected, atol=1e-9)


def test_torque_stays_within_the_drives_limits(plant: MujocoPlant, robot: RobotModel) -> None:
    joints = len(robot.joint_names)
    sign = np.where(np.arange(joints) % 2, 1.0, -1.0)
    zeros = np.zeros(joints)
    plant.step(JointCommand(zeros, zeros, zeros, zeros, 1e4 * sign))
    np.testing.assert_allclose(plant.measure().joint_torque, sign * robot.torque_limit)
    np.testing.assert_allclose(plant.data.qfrc_actuator[BASE_DOFS:], sign * robot.torque_limit)
    assert not plant.data.qfrc_actuator[:BASE_DOFS].any()  # nothing drives the base


def test_gains_change_with_the_command_and_only_in_this_plant(plant: MujocoPlant, robot: RobotModel) -> None:
    joints = plant.measure().joint_position + 0.01
    plant.step(hold(robot, joints))
    strong = plant.measure().joint_torque
    zeros = np.zeros_like(joints)
    plant.step(JointCommand(joints, zeros, zeros, zeros, zeros))
    assert np.abs(strong).max() > 1
    np.testing.assert_array_equal(plant.measure().joint_torque, zeros)
    np.testing.assert_array_equal(robot.model.actuator_biasprm[:, 1], -robot.stiffness)


# ---- sensors --------------------------------------------------------------------------------------------------------


def test_feet_carry_the_weight_of_a_standing_robot(plant: MujocoPlant, robot: RobotModel, upright: Array) -> None:
    for _ in range(600):
        plant.step(hold(robot, upright[BASE_COORDINATES:]))
    left, right = plant.measure().foot_force
    assert left + right == pytest.approx(robot.mass * 9.81, rel=0.03)
    assert left == pytest.approx(right, rel=0.05)


def test_feet_in_the_air_carry_nothing(plant: MujocoPlant, robot: RobotModel, upright: Array) -> None:
    raised = upright.copy()
    raised[2] += 0.5
    plant.place(raised)
    plant.step(hold(robot, upright[BASE_COORDINATES:]))
    np.testing.assert_array_equal(plant.measure().foot_force, [0, 0])


def test_a_measurement_is_a_copy(plant: MujocoPlant, robot: RobotModel, upright: Array) -> None:
    before = plant.measure()
    kept = before.values.copy()
    for _ in range(50):
        plant.step(hold(robot, upright[BASE_COORDINATES:] + 0.05))
    np.testing.assert_array_equal(before.values, kept)


def test_time_counts_servo_periods(plant: MujocoPlant, robot: RobotModel, upright: Array) -> None:
    assert plant.measure().time == 0
    for _ in range(7):
        plant.step(hold(robot, upright[BASE_COORDINATES:]))
    assert plant.measure().time == pytest.approx(7 * SERVO_PERIOD)
    assert plant.data.time == pytest.approx(7 * SERVO_PERIOD)


# ---- external forces ------------------------------------------------------------------------------------------------


def test_nothing_but_contacts_and_gravity_acts_on_the_robot(
    plant: MujocoPlant, robot: RobotModel, upright: Array
) -> None:
    for _ in range(100):
        plant.step(hold(robot, upright[BASE_COORDINATES:]))
        plant.note_external_force()
    assert plant.external_force_max == 0
    assert plant.model.neq == 0
    assert plant.model.nmocap == 0


def test_a_push_is_reported_and_ends(plant: MujocoPlant, robot: RobotModel, upright: Array) -> None:
    plant.push("torso", np.array([0, -40.0, 10.0]), 0.03)
    acted = 0
    for _ in range(60):
        plant.step(hold(robot, upright[BASE_COORDINATES:]))
        acted += bool(plant.data.xfrc_applied.any())
    assert acted == 30
    assert plant.external_force_max == 40
    plant.push("torso", np.array([0, 10.0, 0.0]), 0.01)
    plant.step(hold(robot, upright[BASE_COORDINATES:]))
    assert plant.external_force_max == 40
    assert plant.data.qvel[1] < 0


def test_placing_the_robot_anew_ends_a_push(plant: MujocoPlant, robot: RobotModel, upright: Array) -> None:
    plant.push("torso", np.array([0, -40.0, 10.0]), 1.0)
    plant.step(hold(robot, upright[BASE_COORDINATES:]))
    plant.place(upright)
    plant.step(hold(robot, upright[BASE_COORDINATES:]))
    plant.note_external_force()
    assert plant.external_force_max == 0


def test_a_force_that_somebody_else_applies_is_found_too(plant: MujocoPlant) -> None:
    plant.data.qfrc_applied[2] = 25.0
    plant.note_external_force()
    assert plant.external_force_max == 25


def test_the_truth_is_of_now(plant: MujocoPlant, robot: RobotModel, upright: Array) -> None:
    plant.push("torso", np.array([200.0, 0.0, 0.0]), 0.1)
    for _ in range(100):
        plant.step(hold(robot, upright[BASE_COORDINATES:]))
    truth, now = plant.truth(), mujoco.MjData(plant.model)
    now.qpos[:] = plant.data.qpos
    mujoco.mj_kinematics(plant.model, now)
    np.testing.assert_array_equal(truth.gaze_position, now.site(GAZE_SITE).xpos)
    np.testing.assert_array_equal(truth.base_position, now.qpos[:3])
    assert truth.time == plant.time == 0.1


def test_pushing_a_body_that_is_not_there_names_the_nearest(plant: MujocoPlant) -> None:
    with pytest.raises(UserError, match="no body 'torzo' to push") as error:
        plant.push("torzo", np.zeros(3), 0.1)
    assert "did you mean 'torso'?" in error.value.problems[0].hint


# ---- placing, repeating, blowing up ---------------------------------------------------------------------------------


def test_the_robot_starts_where_the_scene_says(robot: RobotModel, upright: Array) -> None:
    plant = MujocoPlant(robot, scene((2.0, -1.0), math.pi / 2))
    plant.place(upright)
    soles = {side: plant.data.site(sole_site(side)) for side in ("left", "right")}
    middle = (soles["left"].xpos + soles["right"].xpos) / 2
    np.testing.assert_allclose(middle, [2.0, -1.0, 0.0], atol=1e-9)
    for sole in soles.values():
        forward = sole.xmat.reshape(3, 3)[:, 0]
        assert math.atan2(forward[1], forward[0]) == pytest.approx(math.pi / 2, abs=1e-6)
    assert soles["left"].xpos[0] < soles["right"].xpos[0]
    np.testing.assert_allclose(plant.measure().joint_position, upright[BASE_COORDINATES:], atol=1e-11)
    assert not plant.data.qvel.any()


def test_two_plants_do_the_same_bit_for_bit_and_so_does_one_placed_again(robot: RobotModel, upright: Array) -> None:
    def trace(plant: MujocoPlant) -> bytes:
        plant.place(upright)
        plant.push("torso", np.array([30.0, 20.0, 0]), 0.05)
        for _ in range(200):
            plant.step(hold(robot, upright[BASE_COORDINATES:], stiffness=2.0))
        return plant.data.qpos.tobytes() + plant.data.qvel.tobytes() + plant.measure().values.tobytes()

    one, two = MujocoPlant(robot, scene()), MujocoPlant(robot, scene())
    first = trace(one)
    assert trace(two) == first
    zeros = np.zeros(len(robot.joint_names))
    one.step(JointCommand(zeros, zeros, zeros, zeros, zeros))  # leaves other gains behind
    assert trace(one) == first


def test_objects_are_where_the_scene_has_them(robot: RobotModel, upright: Array, tmp_path: Path) -> None:
    path = tmp_path / "scene.yaml"
    path.write_text(
        "format: 1\nname: s\nobjects: {ball: {shape: ball, size: [0.1], position: [1, 0, 1]}}\n"
        "events: [{at: 0.05, move: ball, to: [2, 0, 1]}]\n"
    )
    plant = MujocoPlant(robot, Scene(load_scene(path), 0))
    plant.place(upright)
    np.testing.assert_allclose(plant.data.body("object_ball").xpos, [1, 0, 1])
    for _ in range(60):
        plant.step(hold(robot, upright[BASE_COORDINATES:]))
    plant.move_objects()
    plant.step(hold(robot, upright[BASE_COORDINATES:]))
    np.testing.assert_allclose(plant.data.body("object_ball").xpos, [2, 0, 1])
    plant.place(upright)
    np.testing.assert_allclose(plant.data.body("object_ball").xpos, [1, 0, 1])
    assert len(plant.measure().joint_position) == len(upright) - BASE_COORDINATES


def test_a_simulation_that_blows_up_is_seen_and_not_put_back_to_the_start(
    plant: MujocoPlant, robot: RobotModel, upright: Array, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its warnings into the working directory
    plant.data.qvel[BASE_DOFS] = np.nan
    plant.step(hold(robot, upright[BASE_COORDINATES:]))
    assert not np.isfinite(plant.measure().values).all()
