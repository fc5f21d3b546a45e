"""The simulated sensors: what is true, with noise, bias, resolution and delay; and how they fail."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import SIDES, Array, JointCommand, Reading
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.config import RobotConfig, load_robot_config
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel, foot_sensor
from humanoid_bt.robot.sensor_config import EncoderConfig, FootForceConfig, GyroConfig, SensorsConfig
from tests.sensors import EXACT

SIM = Path(__file__).resolve().parents[2] / "sim"


@pytest.fixture(scope="module")
def config() -> RobotConfig:
    return load_robot_config(SIM / "humanoid" / "robot.yaml")


@pytest.fixture(scope="module")
def standing(config: RobotConfig) -> Array:
    return standing_posture(RobotModel(config))


def plant_with(config: RobotConfig, standing: Array, sensors: SensorsConfig, seed: int = 0) -> MujocoPlant:
    plant = MujocoPlant(RobotModel(replace(config, sensors=sensors)), Scene(SceneConfig(format=1, name="empty"), seed))
    plant.place(standing)
    return plant


def hold(plant: MujocoPlant, joints: Array) -> JointCommand:
    zeros = np.zeros_like(joints)
    return JointCommand(joints, zeros, plant.robot.stiffness, plant.robot.damping, zeros)


def readings(plant: MujocoPlant, standing: Array, cycles: int) -> list[Reading]:
    command = hold(plant, standing[BASE_COORDINATES:])
    found = []
    for _ in range(cycles):
        plant.step(command)
        found.append(plant.measure())
    return found


def test_exact_sensors_say_what_is(config: RobotConfig, standing: Array) -> None:
    plant = plant_with(config, standing, EXACT)
    plant.push("torso", np.array([80.0, 30.0, 0.0]), 0.05)
    readings(plant, standing, 1)
    before = plant.data.qvel[:3].copy()
    (reading,) = readings(plant, standing, 1)
    data, joints = plant.data, len(plant.robot.joint_names)
    near = {"rtol": 0, "atol": 1e-9}
    np.testing.assert_allclose(reading.joint_position, data.qpos[7 : 7 + joints], **near)
    np.testing.assert_allclose(reading.joint_velocity, data.qvel[6 : 6 + joints], **near)
    np.testing.assert_allclose(reading.orientation, data.qpos[3:7], **near)
    np.testing.assert_allclose(reading.gyro, data.qvel[3:6], **near)
    feet = [abs(data.sensor(foot_sensor(side)).data.item(2)) for side in SIDES]
    np.testing.assert_allclose(reading.foot_force, feet, **near)
    felt = rotation_matrix(data.qpos[3:7]).T @ ((data.qvel[:3] - before) / 1e-3 + [0, 0, 9.81])
    np.testing.assert_allclose(reading.accelerometer, felt, atol=1e-6)


def test_torques_are_those_that_moved_the_joints(config: RobotConfig, standing: Array) -> None:
    """Also of drives that damp a quick joint, and of one at its limit: what a foot bears is found from them."""
    plant = plant_with(config, standing, EXACT)
    model, data, joints = plant.model, plant.data, len(standing) - BASE_COORDINATES
    command = hold(plant, standing[BASE_COORDINATES:] + np.where(np.arange(joints) == 3, 1.0, 0.02))
    mass = np.zeros((model.nv, model.nv))
    off, limited = 0.0, False
    for _ in range(20):
        before = data.qvel.copy()
        plant.step(command)
        mujoco.mj_fullM(model, data, mass)
        gained = data.qvel - before
        moved = mass @ gained / 1e-3 + data.qfrc_bias - data.qfrc_passive + model.dof_damping * gained
        moved -= data.qfrc_constraint
        np.testing.assert_allclose(plant.measure().joint_torque, moved[BASE_DOFS : BASE_DOFS + joints], atol=1e-6)
        off = max(off, float(np.abs(plant.measure().joint_torque - data.actuator_force).max()))
        limited = limited or abs(data.actuator_force.item(3)) == plant.robot.torque_limit[3]
    assert limited
    assert off > 1.0  # Nm, by which MuJoCo's own number, of the beginning of its step, is off


def test_a_robot_without_sensors_in_its_feet_says_nothing_of_them(config: RobotConfig, standing: Array) -> None:
    (reading,) = readings(plant_with(config, standing, SensorsConfig()), standing, 1)
    assert reading.foot_force.tolist() == [0, 0]


@pytest.mark.parametrize("delay", [0.0, 0.002, 0.0026, 0.005])
def test_what_is_read_was_so_a_while_ago(config: RobotConfig, standing: Array, delay: float) -> None:
    plant = plant_with(config, standing, replace(EXACT, delay=delay))
    truth, read = [], []
    for _ in range(20):
        read += [reading.joint_velocity.copy() for reading in readings(plant, standing, 1)]
        truth.append(plant.data.qvel[6:].copy())
    late = round(delay / 1e-3)
    np.testing.assert_allclose(read[late:], truth[: len(truth) - late], atol=1e-9)


def test_noise_bias_and_resolution_are_those_of_the_file(config: RobotConfig, standing: Array) -> None:
    sensors = replace(
        EXACT,
        gyro=GyroConfig(noise=0.02, bias=0.5, resolution=0.01),
        encoders=EncoderConfig(noise=0, bias=0, resolution=0.125, speed_noise=0.3, torque_noise=2.0),
        foot_force=FootForceConfig(noise=0, bias=0, resolution=10.0),
    )
    plant = plant_with(config, standing, sensors, seed=3)
    said, true = [], []
    for _ in range(400):
        (reading,) = readings(plant, standing, 1)
        said.append(reading)
        true.append((plant.data.qvel[3:6].copy(), plant.data.qvel[6:].copy(), plant.data.actuator_force.copy()))
    rate, speed, torque = (np.array([row[i] for row in true]) for i in range(3))
    gyro = np.array([reading.gyro for reading in said])
    off = (gyro - rate).mean(axis=0)
    assert 0.02 < np.abs(off).max() < 1.5
    assert (gyro - rate - off).std() == pytest.approx(0.02, rel=0.15)
    np.testing.assert_allclose(gyro * 100, np.rint(gyro * 100), atol=1e-6)
    assert (np.array([reading.joint_velocity for reading in said]) - speed).std() == pytest.approx(0.3, rel=0.05)
    assert (np.array([reading.joint_torque for reading in said]) - torque).std() == pytest.approx(2.0, rel=0.05)
    position, force = said[-1].joint_position, said[-1].foot_force
    np.testing.assert_array_equal(position % 0.125, np.zeros_like(position))
    assert not (force % 10).any()


def test_a_drive_believes_its_encoder(config: RobotConfig, standing: Array) -> None:
    sensors = replace(EXACT, encoders=replace(EXACT.encoders, bias=0.01))
    plant = plant_with(config, standing, sensors)
    wanted = plant.measure().joint_position.copy()  # what the encoders say of where it stands
    off = wanted - standing[BASE_COORDINATES:]
    assert np.abs(off).max() > 0.005
    plant.step(hold(plant, wanted))
    assert np.abs(plant.data.actuator_force).max() < 1.0
    plant.step(hold(plant, standing[BASE_COORDINATES:]))
    assert np.abs(plant.data.actuator_force).max() > 1.0


def test_a_seed_makes_the_noise(config: RobotConfig, standing: Array) -> None:
    def values(plant: MujocoPlant) -> bytes:
        plant.place(standing)
        return b"".join(reading.values.tobytes() for reading in readings(plant, standing, 40))

    one = plant_with(config, standing, SensorsConfig(), seed=1)
    first = values(one)
    assert values(one) == first
    assert values(plant_with(config, standing, SensorsConfig(), seed=1)) == first
    assert values(plant_with(config, standing, SensorsConfig(), seed=2)) != first


def test_a_heading_drifts_and_a_tilt_is_off(config: RobotConfig, standing: Array) -> None:
    orientation = replace(EXACT.orientation, bias=0.02, drift=0.05)
    plant = plant_with(config, standing, replace(EXACT, orientation=orientation))
    said = [reading.orientation.copy() for reading in readings(plant, standing, 400)]
    turned = 2 * (said[-1][3] - said[0][3])  # about the vertical, for small angles
    assert 0.002 < abs(turned) < 0.1
    assert 0.002 < 2 * np.abs(said[0][1:3] - plant.data.qpos[4:6]).max() < 0.1


def test_a_heading_that_has_drifted_far_turns_an_orientation_and_does_not_stretch_it(
    config: RobotConfig, standing: Array
) -> None:
    orientation = replace(EXACT.orientation, bias=0.02, drift=300.0)
    plant = plant_with(config, standing, replace(EXACT, orientation=orientation))
    said = np.array([reading.orientation for reading in readings(plant, standing, 200)])
    np.testing.assert_allclose(np.linalg.norm(said, axis=1), 1.0, atol=1e-3)
    tilts = 1 - 2 * (said[:, 1] ** 2 + said[:, 2] ** 2)
    assert np.ptp(tilts) < 1e-3
    assert said[:, 0].min() < -0.5  # by more than half a revolution


@pytest.mark.parametrize("sensor", ["gyro", "accelerometer", "orientation", "left_knee", "right_foot"])
def test_sensors_fail_as_they_are_told(config: RobotConfig, standing: Array, sensor: str) -> None:
    def of(reading: Reading) -> list[float]:
        if sensor == "right_foot":
            return [reading.foot_force[1]]
        if sensor != "left_knee":
            return list(getattr(reading, sensor))
        joint = plant.robot.joint(sensor)
        return [reading.joint_position[joint], reading.joint_velocity[joint], reading.joint_torque[joint]]

    plant = plant_with(config, standing, SensorsConfig(foot_force=FootForceConfig()))
    for how in ("frozen", "silent", "jumping"):
        plant.place(standing)
        usual = [of(reading) for reading in readings(plant, standing, 10)]
        plant.fail_sensor(sensor, how)
        last, said = np.split(np.array([of(reading) for reading in readings(plant, standing, 20)])[1:], [1])  # delayed
        if how == "frozen":
            assert (said == last).all()
        elif how == "silent":
            assert np.isnan(said).all()
        else:
            assert np.abs(np.diff(said[:, 0])).max() > 10 * np.abs(np.diff(np.array(usual)[:, 0])).max()


def test_there_is_no_such_failure(config: RobotConfig, standing: Array) -> None:
    plant = plant_with(config, standing, SensorsConfig())
    with pytest.raises(ValueError, match="cannot fail 'slow'; valid: frozen, silent, jumping"):
        plant.fail_sensor("gyro", "slow")
    with pytest.raises(ValueError, match="no sensor 'giro'; valid: imu, "):
        plant.fail_sensor("giro", "silent")
    with pytest.raises(ValueError, match="no sensor 'left_foot'"):  # in this robot
        plant.fail_sensor("left_foot", "silent")


def test_what_fails_fails_besides_what_has_failed_already_and_alone(config: RobotConfig, standing: Array) -> None:
    plant = plant_with(config, standing, replace(EXACT, foot_force=FootForceConfig()))
    for sensor in ("left_knee", "right_foot", "imu"):
        plant.fail_sensor(sensor, "silent")
    (reading,) = readings(plant, standing, 1)
    assert np.isnan([*reading.gyro, *reading.accelerometer, *reading.orientation]).all()
    assert np.isnan(reading.foot_force).tolist() == [False, True]
    for said in (reading.joint_position, reading.joint_velocity, reading.joint_torque):
        assert np.flatnonzero(np.isnan(said)).tolist() == [plant.robot.joint("left_knee")]


def test_an_orientation_is_off_by_its_noise(config: RobotConfig, standing: Array) -> None:
    plant = plant_with(config, standing, replace(EXACT, orientation=replace(EXACT.orientation, noise=0.02)))
    off = np.array([reading.orientation[1:] for reading in readings(plant, standing, 500)]) - plant.data.qpos[4:7]
    assert 2 * off.std() == pytest.approx(0.02, rel=0.1)  # rad, about each axis


def test_a_robot_that_is_placed_anew_is_felt_to_be_at_rest(config: RobotConfig, standing: Array) -> None:
    plant = plant_with(config, standing, EXACT)
    plant.push("torso", np.array([300.0, 0.0, 0.0]), 0.1)
    readings(plant, standing, 100)
    plant.place(standing)
    up = -plant.model.opt.gravity[2]
    np.testing.assert_allclose(plant.measure().accelerometer, [0.0, 0.0, up], atol=1e-3)
    np.testing.assert_allclose(plant.measure().joint_torque, plant.data.actuator_force, atol=1e-9)
