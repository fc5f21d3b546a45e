"""Sensors that fail are noticed within 50 ms, and the robot stops and stands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.control.estimator.sensor_watch import SensorWatch
from humanoid_bt.core.clock import ESTIMATE_PERIOD
from humanoid_bt.core.messages import BaseTarget, Mode, Reading
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.robot.sensor_config import (
    AccelerometerConfig,
    EncoderConfig,
    FootForceConfig,
    GyroConfig,
    OrientationConfig,
)
from tests.control.control_rig import ControlRig

BETWEEN_LOOKS, IN_A_LOOK, IN_THE_NEXT = 302, 305, 310  # cycles; in one of these two turns are compared
WALK = {"base": BaseTarget(np.array([2.0, 0.3]), 0.0)}
FAILURES = {
    ("gyro", "frozen"): "the gyro is frozen",
    ("gyro", "silent"): "the gyro is silent",
    ("gyro", "jumping"): "the gyro jumps",
    ("accelerometer", "frozen"): "the accelerometer is frozen",
    ("accelerometer", "silent"): "the accelerometer is silent",
    ("accelerometer", "jumping"): "the accelerometer jumps",
    ("orientation", "frozen"): "the orientation is frozen",
    ("orientation", "silent"): "the orientation is silent",
    ("orientation", "jumping"): "the orientation jumps",
    ("left_knee", "frozen"): "the sensors of left_knee are frozen",
    ("right_hip_roll", "silent"): "the sensors of right_hip_roll are silent",
    ("left_elbow", "jumping"): "the sensors of left_elbow jumped",
}


@pytest.mark.parametrize(("sensor", "how"), FAILURES)
def test_a_sensor_that_fails_is_noticed(rig: ControlRig, sensor: str, how: str) -> None:
    rig.run(0.3, {})
    rig.plant.fail_sensor(sensor, how)
    rig.run(0.06, {})
    (stop,) = rig.controller.supervisor.stops
    assert stop.reason == f"a sensor failed: {FAILURES[sensor, how]}"
    assert stop.mode is Mode.PROTECTIVE_STOP
    assert 0.3 < stop.time <= 0.35


def rig_with(robot: RobotModel, standing: np.ndarray, **sensors: Any) -> ControlRig:
    config = robot.config
    return ControlRig(RobotModel(replace(config, sensors=replace(config.sensors, **sensors))), standing)


@pytest.fixture(scope="module")
def feeling(robot: RobotModel, standing: np.ndarray) -> ControlRig:
    """A robot with force sensors in its feet."""
    return rig_with(robot, standing, foot_force=FootForceConfig())


@pytest.mark.parametrize(
    ("sensor", "how", "what"),
    [
        ("left_foot", "frozen", "is frozen"),
        ("right_foot", "silent", "is silent"),
        ("left_foot", "jumping", "says what no foot bears"),
    ],
)
def test_a_force_sensor_that_fails_is_noticed_and_legs_say_what_the_feet_bear(
    feeling: ControlRig, sensor: str, how: str, what: str
) -> None:
    feeling.reset()
    feeling.run(0.3, {})
    feeling.plant.fail_sensor(sensor, how)
    feeling.run(0.06, {})
    (stop,) = feeling.controller.supervisor.stops
    assert stop.reason == f"a sensor failed: the force sensor of the {sensor.replace('_', ' ')} {what}"
    assert 0.3 < stop.time <= 0.35
    assert feeling.controller.estimator.load.standing == [True, True]
    assert sum(feeling.state.foot_force.values()) == pytest.approx(feeling.robot.mass * GRAVITY, rel=0.2)


def looked(robot: RobotModel, change: Callable[[Reading, int], None], upright: bool) -> SensorWatch:
    """Return what watches a robot that stands still, whose readings are changed, after ten looks."""
    watch, reading = SensorWatch(robot), Reading(len(robot.joint_names))
    numbers = np.random.default_rng(0)
    watch.reset(reading)
    for look in range(10):
        reading.values[:] = numbers.normal(0.0, 1e-4, len(reading.values))
        reading.orientation[0] += 1.0
        change(reading, look)
        watch.look(reading, reading.rates.copy(), ESTIMATE_PERIOD, upright)
    return watch


def jolted(reading: Reading, look: int) -> None:
    reading.accelerometer[:] += 200.0 * (look % 2)


def shaking(reading: Reading, look: int) -> None:
    """A body that is controlled with what an accelerometer says shakes when that jumps."""
    jolted(reading, look)
    reading.joint_velocity[:2] += 3.0 * (look % 2) * (look > 1)


def torn(reading: Reading, look: int) -> None:
    reading.joint_position[3] += look % 2


def trodden(reading: Reading, _look: int) -> None:
    reading.foot_force[0] += 1e5


def turning(reading: Reading, look: int) -> None:
    reading.gyro[:] += 2.0 * look  # and the orientation says that it does not


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (jolted, "the accelerometer jumps"),
        (shaking, "the accelerometer jumps"),
        (turning, "the gyro says something else than the orientation"),
        (torn, "the sensors of left_knee jumped"),
        (trodden, "the force sensor of the left foot says what no foot bears"),
    ],
)
def test_a_robot_that_falls_may_throw_its_sensors_about(
    feeling: ControlRig, change: Callable[[Reading, int], None], what: str
) -> None:
    assert looked(feeling.robot, change, upright=True).fault == what
    assert looked(feeling.robot, change, upright=False).fault == ""


@pytest.mark.parametrize(
    ("wrong", "fault"), [({2}, ""), ({2, 7}, "the force sensor of the left foot says what no"), ({2, 9}, "")]
)
def test_a_foot_that_says_now_and_then_what_no_foot_bears_has_failed(
    feeling: ControlRig, wrong: set[int], fault: str
) -> None:
    def sometimes(reading: Reading, look: int) -> None:
        reading.foot_force[0] += 1e5 * (look in wrong)

    found = looked(feeling.robot, sometimes, upright=True).fault
    assert found.startswith(fault)
    assert bool(found) is bool(fault)


def test_what_failed_first_stays_told(feeling: ControlRig) -> None:
    def one_after_the_other(reading: Reading, look: int) -> None:
        torn(reading, look) if look > 7 else jolted(reading, look)

    assert looked(feeling.robot, one_after_the_other, upright=True).fault == "the accelerometer jumps"


@pytest.mark.parametrize(("noise", "what"), [(2e-3, "the gyro is frozen"), (0.0, "")])
def test_a_sensor_without_noise_may_say_the_same_for_ever(robot: RobotModel, noise: float, what: str) -> None:
    config = robot.config
    sensors = replace(config.sensors, gyro=GyroConfig(noise=noise))

    def frozen(reading: Reading, _look: int) -> None:
        reading.gyro[:] = 0.0

    assert looked(RobotModel(replace(config, sensors=sensors)), frozen, upright=True).fault == what


@pytest.mark.trials
@pytest.mark.parametrize("how", ["frozen", "silent", "jumping"])
def test_a_robot_that_walks_stops_and_stands_without_a_force_sensor(feeling: ControlRig, how: str) -> None:
    feeling.reset()
    feeling.run(1.5, WALK)
    feeling.plant.fail_sensor("left_foot", how)
    feeling.run(1.0, WALK)
    assert feeling.state.mode is Mode.PROTECTIVE_STOP
    assert feeling.stands()


@pytest.mark.parametrize(
    ("sensor", "noise"),
    [
        ("orientation", OrientationConfig(noise=0.02)),
        ("accelerometer", AccelerometerConfig(noise=10.0)),
        ("encoders", EncoderConfig(noise=0.03)),
        ("encoders", EncoderConfig(speed_noise=1.0, torque_noise=10.0, torque_bias=1.0)),
    ],
)
def test_noise_that_the_robots_file_tells_of_is_no_failure(
    robot: RobotModel, standing: np.ndarray, sensor: str, noise: object
) -> None:
    rig = rig_with(robot, standing, **{sensor: noise})
    rig.run(0.6, {})
    assert rig.controller.estimator.watch.fault == ""


@pytest.mark.parametrize(
    ("sensor", "place", "value", "cycle"),
    [
        ("gyro", 0, 35.0, BETWEEN_LOOKS),
        ("gyro", 1, 1e6, BETWEEN_LOOKS),
        ("gyro", 0, 35.0, IN_A_LOOK),
        ("gyro", 1, 1e6, IN_THE_NEXT),
        ("orientation", 1, 0.7, IN_A_LOOK),
        ("orientation", 2, 0.7, IN_THE_NEXT),
        ("orientation", 1, 0.04, IN_A_LOOK),
        ("orientation", 2, 0.04, IN_THE_NEXT),
        ("accelerometer", 0, 500.0, BETWEEN_LOOKS),
        ("accelerometer", 0, 500.0, IN_A_LOOK),
        ("joint_torque", 20, np.nan, BETWEEN_LOOKS),
        ("joint_torque", 25, 300.0, BETWEEN_LOOKS),
        ("joint_velocity", 25, 1e3, IN_A_LOOK),
        ("joint_velocity", 3, 1e300, IN_A_LOOK),
    ],
)
def test_one_wrong_reading_does_no_harm(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch, sensor: str, place: int, value: float, cycle: int
) -> None:
    measure = rig.plant.measure

    def wrong_once(into: Reading | None = None) -> Reading:
        reading = measure(into)
        if rig.controller.cycle == cycle:
            getattr(reading, sensor)[place] = value
        return reading

    monkeypatch.setattr(rig.plant, "measure", wrong_once)
    rig.run(0.4, {})
    estimator, data = rig.controller.estimator, rig.plant.data
    off = estimator.estimate.qpos[3:7] - data.qpos[3:7], estimator.estimate.qvel[:3] - data.qvel[:3]
    assert 2 * np.abs(off[0]).max() < 0.015
    assert np.abs(off[1]).max() < 0.1
    assert np.isfinite(list(estimator.contact.forces.values())).all()
    assert not rig.controller.supervisor.touch.yielding
    assert rig.state.mode is Mode.RUN


@pytest.mark.parametrize("rate", [5.0, 34.9])
def test_a_gyro_that_says_too_much_for_good_is_noticed(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch, rate: float
) -> None:
    measure = rig.plant.measure

    def saturated(into: Reading | None = None) -> Reading:
        reading = measure(into)
        if rig.controller.cycle >= IN_A_LOOK:
            reading.gyro[1] = rate
        return reading

    monkeypatch.setattr(rig.plant, "measure", saturated)
    rig.run(0.4, {})
    (stop,) = rig.controller.supervisor.stops
    assert stop.reason.startswith("a sensor failed: the gyro")
    assert stop.mode is Mode.PROTECTIVE_STOP
    assert stop.time <= 0.35


@pytest.mark.parametrize("joint", ["left_knee", "right_elbow"])
@pytest.mark.parametrize(("sensor", "most"), [("joint_velocity", 500.0), ("joint_torque", 3000.0)])
def test_a_joint_whose_speed_or_torque_cannot_be_is_noticed(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch, joint: str, sensor: str, most: float
) -> None:
    measure, rng, place = rig.plant.measure, np.random.default_rng(0), rig.robot.joint(joint)

    def wild(into: Reading | None = None) -> Reading:
        reading = measure(into)
        if rig.controller.cycle > 300:
            getattr(reading, sensor)[place] = rng.uniform(-most, most)
        return reading

    monkeypatch.setattr(rig.plant, "measure", wild)
    rig.run(0.4, {})
    (stop,) = rig.controller.supervisor.stops
    assert stop.reason == f"a sensor failed: the sensors of {joint} say what cannot be"
    assert stop.mode is Mode.PROTECTIVE_STOP
    assert stop.time <= 0.35
    assert not rig.controller.supervisor.touch.yielding


@pytest.mark.parametrize("derived", [0.0, 0.2 / ESTIMATE_PERIOD], ids=["at rest", "its speed is derived from it"])
def test_every_joint_whose_angle_jumps_is_noticed(rig: ControlRig, derived: float) -> None:
    rig.run(0.5, {})
    watch, reading, joints = rig.controller.estimator.watch, Reading(len(rig.robot.joint_names)), rig.robot.joint_names
    before = rig.plant.measure()
    for place, joint in enumerate(joints):
        watch.reset(before)
        reading.values[:] = before.values
        reading.joint_position[place] += 0.2
        rates = reading.rates.copy()
        rates[6 + place] += derived  # between two looks
        watch.look(reading, rates, ESTIMATE_PERIOD, upright=True)
        assert watch.fault == f"the sensors of {joint} jumped"


@pytest.mark.parametrize("time", [ESTIMATE_PERIOD, 0.007, 2 * ESTIMATE_PERIOD])
@pytest.mark.parametrize("turns_so", [True, False])
def test_a_joint_that_is_struck_turns_as_fast_as_it_says(rig: ControlRig, time: float, turns_so: bool) -> None:
    """A light one faster than any drive turns it: the wrist of a G1 at 110 rad/s, by 400 N."""
    rig.run(0.5, {})
    watch, reading = rig.controller.estimator.watch, Reading(len(rig.robot.joint_names))
    reading.values[:] = rig.plant.measure().values
    for speed in (40.0, 80.0, 110.0, 70.0, -30.0, 0.0):
        rates = reading.rates.copy()
        reading.values[:] += 1e-9  # nothing is frozen
        reading.joint_velocity[-1] = speed
        rates[5 + len(rig.robot.joint_names)] = speed
        reading.joint_position[-1] += speed * time * turns_so
        watch.look(reading, rates, time, upright=True)
        if turns_so:
            assert not watch.any_bad
    assert bool(watch.fault) is not turns_so


@pytest.mark.trials
@pytest.mark.parametrize(("sensor", "how"), [("gyro", "silent"), ("accelerometer", "frozen"), ("left_knee", "jumping")])
def test_a_robot_that_walks_stops_and_stands_without_a_sensor(rig: ControlRig, sensor: str, how: str) -> None:
    rig.run(2.0, WALK)
    rig.plant.fail_sensor(sensor, how)
    rig.run(1.0, WALK)
    assert rig.state.mode is Mode.PROTECTIVE_STOP
    assert rig.stands()
    assert rig.plant.data.qpos[2] == pytest.approx(rig.standing[2], rel=0.05)
    rig.run(0.5, WALK)
    assert rig.state.mode is Mode.PROTECTIVE_STOP  # until the run ends


@pytest.mark.parametrize(
    ("sensors", "fault"),
    [
        (["imu"], "the whole IMU is silent"),
        (["gyro", "orientation"], "the gyro is silent, the orientation is silent"),
        (["imu", "left_knee"], "the whole IMU is silent, the sensors of left_knee are silent"),
    ],
)
def test_sensors_that_fail_together_are_named_together(rig: ControlRig, sensors: list[str], fault: str) -> None:
    rig.run(0.1, {})
    for sensor in sensors:
        rig.plant.fail_sensor(sensor, "silent")
    rig.run(0.06, {})
    assert rig.controller.estimator.watch.fault == fault
    assert fault in rig.state.stop_reason


def test_sensors_that_work_are_believed(rig: ControlRig, robot: RobotModel) -> None:
    rig.run(0.5, {})
    rig.plant.push(robot.config.torso, np.array([60.0, 80.0, 0.0]), 0.1)
    rig.run(2.5, WALK)
    assert rig.controller.estimator.watch.fault == ""
    assert rig.state.mode is Mode.RUN


def test_what_happened_while_a_plant_was_silent_is_no_failed_sensor(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Old readings are not judged at all, and the first new one is compared with none: a limb may have gone far."""
    rig.run(0.5, {})
    measure, offset, age = rig.plant.measure, 0.0, 0.0

    def late(into: Reading | None = None) -> Reading:
        reading = measure(into)
        reading.joint_position[-1] += offset
        reading.age = age
        return reading

    monkeypatch.setattr(rig.plant, "measure", late)
    position, time = rig.state.base_position, rig.state.time
    age = 0.021
    rig.run(0.2, {})
    assert rig.controller.estimator.watch.fault == ""
    assert np.array_equal(rig.state.base_position, position)
    assert rig.state.time == pytest.approx(time + 0.2)
    offset, age = 0.5, 0.0
    rig.run(0.2, {})
    assert rig.controller.estimator.watch.fault == ""
    offset = 1.0
    rig.run(0.2, {})
    assert "jumped" in rig.controller.estimator.watch.fault


@pytest.mark.parametrize(
    ("joints", "turned", "fault"),
    [(5.0, True, ""), (5.0, False, "the gyro jumps"), (0.0, True, "the gyro jumps")],
    ids=["joints and orientation say so, too", "orientation does not", "joints do not"],
)
def test_a_gyro_that_jumps_is_believed_in_a_blow(rig: ControlRig, joints: float, turned: bool, fault: str) -> None:
    rig.run(0.5, {})
    watch, reading = rig.controller.estimator.watch, Reading(len(rig.robot.joint_names))
    reading.values[:] = rig.plant.measure().values
    w, x, y, z = reading.orientation
    for rate in (6.0, -6.0, 6.0):
        reading.values[:] += 1e-9  # nothing is frozen
        reading.gyro[:] = 0.0, rate, 0.0
        reading.joint_velocity[:] += np.sign(rate) * joints
        half = rate * 0.005 / 2 if turned else 0.0
        w, x, y, z = w - y * half, x - z * half, y + w * half, z + x * half  # turned about its own y
        reading.orientation[:] = w, x, y, z
        watch.look(reading, reading.rates, ESTIMATE_PERIOD, upright=True)
    assert watch.fault == fault


@pytest.mark.parametrize(("rate", "fault"), [(25.0, ""), (0.0, "the orientation jumps")])
def test_an_orientation_that_turns_as_the_gyro_says_does_not_jump(rig: ControlRig, rate: float, fault: str) -> None:
    """A light robot whose hand is struck with 400 N turns by 0.1 rad from look to look."""
    rig.run(0.5, {})
    watch, reading = rig.controller.estimator.watch, Reading(len(rig.robot.joint_names))
    reading.values[:] = rig.plant.measure().values
    turn = np.arctan2(reading.orientation[3], reading.orientation[0])
    for _ in range(5):
        turn += 25.0 * ESTIMATE_PERIOD / 2
        reading.values[:] += 1e-9  # nothing is frozen
        reading.gyro[:] = 0.0, 0.0, rate
        reading.orientation[:] = np.cos(turn), 0.0, 0.0, np.sin(turn)
        watch.look(reading, reading.rates, ESTIMATE_PERIOD, upright=True)
    assert watch.fault == fault


@pytest.mark.parametrize(("jump", "doubted"), [(35.0, False), (70.0, True)], ids=["as of a landing foot", "wild"])
def test_an_accelerometer_is_doubted_where_it_jumps_wildly(rig: ControlRig, jump: float, doubted: bool) -> None:
    """Feet that land hard make it jump, too, and then it is right."""
    rig.run(0.5, {})
    watch, reading = rig.controller.estimator.watch, Reading(len(rig.robot.joint_names))
    reading.values[:] = rig.plant.measure().values
    reading.accelerometer[2] += jump
    watch.look(reading, reading.rates, ESTIMATE_PERIOD, upright=True)
    assert watch.suspicious
    assert ("accelerometer" in watch.doubted) == doubted
    for _ in range(4):
        reading.values[:] += 1e-9  # nothing is frozen
        watch.look(reading, reading.rates, ESTIMATE_PERIOD, upright=True)
    assert "accelerometer" not in watch.doubted
