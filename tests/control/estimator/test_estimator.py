"""The estimator in the loop: a robot that walks on what its sensors say."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.controller import Controller
from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.control.estimator.estimator import Estimator
from humanoid_bt.control.estimator.invariant_filter import FREE, InvariantFilter
from humanoid_bt.core.clock import ESTIMATE_PERIOD, cycles
from humanoid_bt.core.messages import SIDES, BaseTarget, Estimate, JointCommand, Mode, Reading
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel, foot_sensor, sole_site
from humanoid_bt.robot.sensor_config import FootForceConfig
from tests.control.conftest import ROBOT
from tests.control.control_rig import ControlRig

WALK = {"base": BaseTarget(np.array([1.0, 0.3]), 0.5)}


class Log:
    """How far the estimate was from the truth, every tick."""

    def __init__(self, rig: ControlRig) -> None:
        self.rig = rig
        self.position, self.velocity, self.force = [], [], []

    def __call__(self, _: object) -> bool:
        plant, estimate = self.rig.plant, self.rig.controller.estimator.estimate
        self.position.append(estimate.qpos[:3] - plant.data.qpos[:3])
        self.velocity.append(estimate.qvel[:3] - plant.data.qvel[:3])
        borne = [abs(plant.data.sensor(foot_sensor(side)).data.item(2)) for side in SIDES]
        self.force.append(estimate.foot_force - borne)
        return False


@pytest.mark.parametrize("feet", [None, FootForceConfig()], ids=["by torques", "by sensors in the feet"])
def test_a_robot_walks_on_what_its_sensors_say(robot: RobotModel, standing: np.ndarray, feet: object) -> None:
    if feet is not None:
        config = load_robot_config(ROBOT)
        robot = RobotModel(replace(config, sensors=replace(config.sensors, foot_force=feet)))
    rig = ControlRig(robot, standing)
    log = Log(rig)
    rig.run(4.0, WALK, until=log)
    assert rig.state.mode is Mode.RUN
    position, velocity, force = np.array(log.position), np.array(log.velocity), np.array(log.force)
    assert 0 < np.abs(position).max() < 0.02
    assert np.sqrt((velocity**2).mean(axis=0)).max() < 0.03
    assert np.percentile(np.abs(force), 90) < 0.15 * robot.mass * GRAVITY
    way = math.hypot(*rig.plant.data.qpos[:2])
    assert way > 0.6


def test_feet_carry_the_weight_of_a_standing_robot(rig: ControlRig, robot: RobotModel) -> None:
    rig.run(0.5, {})
    forces = []
    rig.run(0.5, {}, until=lambda state: bool(forces.append(sum(state.foot_force.values()))))
    assert np.mean(forces) == pytest.approx(robot.mass * GRAVITY, rel=0.05)


def test_it_is_where_it_was_told(robot: RobotModel, standing: np.ndarray) -> None:
    rig = ControlRig(robot, standing)
    rig.controller.reset((3.0, -2.0, 1.2))
    np.testing.assert_allclose(rig.state.stance, [3.0, -2.0, 1.2], atol=1e-6)
    rig.run(1.0, {})
    np.testing.assert_allclose(rig.state.stance, [3.0, -2.0, 1.2], atol=5e-3)


def test_a_robot_that_lies_does_not_drift_away(rig: ControlRig) -> None:
    rig.run(0.1, {})
    rig.plant.push("torso", np.array([600.0, 0, 0]), 0.2)
    assert rig.run(3.0, {}, until=lambda state: state.mode is Mode.DAMP)
    rig.run(2.0)
    lying = rig.state.base_position
    rig.run(5.0)
    assert np.abs(rig.state.base_position - lying)[:2].max() < 0.02
    assert rig.state.base_position[2] < 0.4


class Played:
    """A plant that is none: the same readings as before, whatever is commanded."""

    fault = ""

    def __init__(self, readings: list[np.ndarray]) -> None:
        self._readings, self._next, self.commands = readings, 0, []

    def measure(self, into: Reading | None = None) -> Reading:
        values = self._readings[self._next]
        self._next += 1
        reading = into or Reading((len(values) - 12) // 3)
        reading.values[:], reading.time = values, (self._next - 1) * 1e-3
        return reading

    def step(self, command: JointCommand) -> None:
        self.commands.append(np.concatenate([command.position, command.velocity, command.torque]))


def test_control_knows_nothing_but_readings(robot: RobotModel, standing: np.ndarray) -> None:
    """Given the same readings again, without any simulation behind them, it commands the same, bit for bit."""
    rig, heard, commanded = ControlRig(robot, standing), [], []
    measure, step = rig.plant.measure, rig.plant.step

    def overheard(into: Reading | None = None) -> Reading:
        reading = measure(into)
        heard.append(reading.values.copy())
        return reading

    def noted(command: JointCommand) -> None:
        commanded.append(np.concatenate([command.position, command.velocity, command.torque]))
        step(command)

    rig.plant.measure, rig.plant.step = overheard, noted
    rig.reset()
    rig.run(1.5, WALK)
    played = Played(heard)
    again = object.__new__(ControlRig)
    again.robot, again.standing, again.plant, again.sequence = robot, standing, played, 0
    again.controller = Controller(robot, played)
    again.run(1.5, WALK)
    np.testing.assert_array_equal(played.commands, commanded)


def test_single_silences_of_the_gyroscope_long_apart_turn_nothing(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    measure, fastest = rig.plant.measure, 0.0

    def measured(into: Reading | None = None) -> Reading:
        reading = measure(into)
        if rig.controller.cycle in (1500, 3500):  # the robot has turned by a good part of a turn between the two
            reading.gyro[:] = np.nan
        return reading

    def watch() -> None:
        nonlocal fastest
        fastest = max(fastest, float(np.abs(rig.controller.estimator.estimate.qvel[3:6]).max()))

    monkeypatch.setattr(rig.plant, "measure", measured)
    rig.run(4.5, {"base": BaseTarget(np.zeros(2), 2.5)}, cycle=watch)
    assert rig.state.mode is Mode.RUN
    assert not rig.controller.estimator.watch.failed
    assert fastest < 3.0


def test_a_foot_stands_on_the_ground_that_it_finds_not_where_it_once_was(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A robot that fell is put back on its feet, first on the left one."""
    estimator = rig.controller.estimator
    explain, stands = estimator.load.explain, [False, False]

    def explained(*motion: np.ndarray) -> None:
        explain(*motion)
        estimator.load.standing[:] = stands

    rig.run(0.1, {})
    monkeypatch.setattr(estimator.load, "explain", explained)
    rig.run(0.4, {})
    estimator._ground.heights = [-0.5, -0.5]  # where they were when they last touched something
    stands[:] = True, False
    for _ in range(cycles(ESTIMATE_PERIOD)):
        rig.controller.run_cycle()
    stands[:] = True, True
    errors: list[float] = []
    rig.run(0.1, {}, cycle=lambda: errors.append(estimator.estimate.qpos[2] - rig.plant.data.qpos[2]))
    assert np.abs(errors).max() < 5e-3


def test_a_robot_whose_feet_slide_knows_where_it_is(robot: RobotModel, standing: np.ndarray) -> None:
    rig = ControlRig(robot, standing)
    rig.plant.alter(friction=0.05)
    rig.reset()
    rig.run(0.5, {})
    soles = [rig.plant.data.site(sole_site(side)) for side in SIDES]
    before = np.array([sole.xpos[:2].copy() for sole in soles])
    rig.plant.push("torso", np.array([0.0, 120.0, 0.0]), 0.1)
    rig.run(0.24, {})
    slid = np.hypot(*(np.array([sole.xpos[:2] for sole in soles]) - before).T)
    off = rig.controller.estimator.estimate.qpos[:2] - rig.plant.data.qpos[:2]
    assert slid.min() > 0.03
    assert np.hypot(*off) < 0.01


@pytest.mark.parametrize("moment", [1.2, 1.3, 1.4])
def test_an_accelerometer_that_jumps_moves_the_estimate_hardly(rig: ControlRig, moment: float) -> None:
    """Not before it is known to fail, nor afterwards, when the legs say how fast the base is."""
    rig.run(moment, WALK)
    log = Log(rig)
    log(None)
    rig.plant.fail_sensor("accelerometer", "jumping")
    rig.run(0.5, WALK, until=log)
    assert rig.controller.estimator.watch.failed == {"accelerometer"}
    position, velocity = np.array(log.position), np.array(log.velocity)
    assert np.abs(position - position[0]).max() < 0.01
    assert np.abs(velocity - velocity[0]).max() < 0.35


def test_legs_say_how_fast_the_base_is_without_an_accelerometer(rig: ControlRig) -> None:
    """The robot brakes for the stop that follows: taken to move on as before it would be 0.05 m/s off."""
    rig.run(1.2, WALK)
    log = Log(rig)
    rig.plant.fail_sensor("accelerometer", "silent")
    rig.run(0.6, WALK, until=log)
    assert np.sqrt((np.array(log.velocity) ** 2).mean()) < 0.035


def test_legs_say_nothing_of_the_velocity_where_no_gyroscope_says_how_they_are_turned(
    rig: ControlRig, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With it four times as many robots fell that lost the whole IMU as they walked."""
    asked: list[np.ndarray] = []
    monkeypatch.setattr(InvariantFilter, "slow", lambda _, velocity: asked.append(velocity))
    rig.run(1.2, WALK)
    rig.plant.fail_sensor("imu", "silent")
    rig.run(0.2, WALK)
    assert rig.controller.estimator.watch.failed == {"gyro", "accelerometer", "orientation"}
    assert not asked


@pytest.mark.parametrize("moment", [0.96, 1.2, 1.3, 1.44])
def test_after_a_silence_it_is_known_again_how_the_robot_moves(
    rig: ControlRig, moment: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Silence in mid-step: the robot is stopped there, and falls onto a foot; at first not the one that carried it."""
    rig.run(moment, WALK)
    estimator, data = rig.controller.estimator, rig.plant.data
    rig.silence(monkeypatch, 0.09)
    rig.run(0.08, WALK)
    assert rig.state.mode is Mode.PROTECTIVE_STOP
    assert np.linalg.norm(estimator.estimate.qvel[:2] - data.qvel[:2]) > 0.04  # as it was before
    off: list[float] = []
    rig.run(0.04, WALK, cycle=lambda: off.append(float(np.linalg.norm(estimator.estimate.qvel[:2] - data.qvel[:2]))))
    assert max(off[14:19]) < 0.06  # with the first update after the silence, and not with the second one, 5 ms later
    log, tilts = Log(rig), []
    rig.run(0.3, WALK, lambda _: log(None), lambda: tilts.append(estimator.estimate.qpos[4:6] - data.qpos[4:6]))
    assert np.sqrt((np.array(log.velocity)[:, :2] ** 2).sum(axis=1).mean()) < 0.04
    assert np.abs(2 * np.array(tilts)).max() < 0.02


class Told:
    """An estimator of a robot that stands, and what its sensors say: that nothing but gravity acts, not even drives."""

    def __init__(self, robot: RobotModel, standing: np.ndarray) -> None:
        self.reading = Reading(len(robot.joint_names))
        self.reading.orientation[:], self.reading.joint_position[:] = standing[3:7], standing[7:]
        self.reading.accelerometer[2] = GRAVITY
        self.estimator = Estimator(robot, RobotDynamics(robot))
        self.estimator.reset(self.reading, (0.0, 0.0, 0.0))

    def take(self, *periods: int, ahead: float = 0.0) -> None:
        """Tell so many servo periods in each of these cycles, in which the base accelerates ahead [m/s^2]."""
        self.reading.accelerometer[0] = ahead
        for self.reading.passed in periods:
            self.estimator.take(self.reading)

    def update(self) -> Estimate:
        joints = len(self.reading.joint_position)
        return self.estimator.update(self.reading, np.zeros((3, joints)))

    @property
    def feels(self) -> bool:
        """Whether it feels anything touch the robot after an update."""
        self.update()
        return any(force.any() for force in self.estimator.contact.forces.values())


@pytest.fixture
def told(robot: RobotModel, standing: np.ndarray) -> Told:
    return Told(robot, standing)


def test_a_reading_stands_for_all_the_time_that_it_tells_of(told: Told) -> None:
    told.take(1, ahead=1.0)
    told.take(0, 0, 3, ahead=2.0)
    assert told.estimator.heard == 4
    assert told.update().qvel[0] == pytest.approx(0.001 * 1.0 + 0.003 * 2.0, rel=1e-3)
    assert told.estimator.heard == 0


def test_time_that_was_missed_does_not_count_again_when_a_reading_tells_of_it(told: Told) -> None:
    told.take(1, 0, 0)
    told.estimator.miss(told.reading)
    assert told.estimator.heard == 0
    told.take(4)
    assert told.estimator.heard == 1
    told.take(2)
    assert told.estimator.heard == 3


def test_the_robot_goes_on_moving_for_all_the_time_that_was_missed(told: Told) -> None:
    told.take(1, 1, 1, 1, 1, ahead=1.0)
    before = told.update().qpos[0]
    told.take(1, 0, 0)
    told.estimator.miss(told.reading)
    told.take(1)
    assert told.update().qpos[0] - before == pytest.approx(0.005 * 0.005, rel=0.01)


@pytest.mark.parametrize(
    ("periods", "feels"), [((0, 0, 3), True), ((3,), True), ((0, 0, 0, 1), False), ((4,), False), ((4, 2), False)]
)
def test_after_a_gap_it_is_not_known_what_touches_the_robot(told: Told, periods: tuple[int, ...], feels: bool) -> None:
    told.take(1, 1, 1, 1, 1)
    assert told.feels
    told.take(*periods)
    assert told.feels == feels
    told.take(1)
    assert told.feels


def test_a_sole_that_seems_to_slide_for_long_is_believed_again(told: Told, monkeypatch: pytest.MonkeyPatch) -> None:
    load, belief, slips = told.estimator.load, told.estimator._filter, []

    def carried(*_: object) -> None:
        load.force[:], load.standing[:] = (1000.0, 0.0), (True, False)

    def corrected(soles: np.ndarray, *_: object) -> None:
        belief.feet[:] = soles - [[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]

    monkeypatch.setattr(load, "explain", carried)
    monkeypatch.setattr(belief, "correct", corrected)
    corrected(belief.feet)
    monkeypatch.setattr(belief, "doubt", lambda time, slip: slips.append(slip[0]))
    noise, exact = np.random.default_rng(0), told.reading.values.copy()
    for _ in range(120):
        told.reading.values[:] = exact + 1e-4 * noise.standard_normal(len(exact))  # what never changes is broken
        told.take(1, 1, 1, 1, 1)
        told.update()
    free = slips.count(FREE)
    assert free * 3 * ESTIMATE_PERIOD == pytest.approx(0.3, abs=0.02)
    assert slips == [FREE] * free + [1.0] * (len(slips) - free)
