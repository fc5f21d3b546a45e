from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.body.body import Setpoint
from humanoid_bt.control.servo import Servo
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel

PERIOD = 0.01  # s


@pytest.fixture
def servo(robot: RobotModel, standing: Array) -> Servo:
    servo = Servo(robot)
    servo.reset(standing[BASE_COORDINATES:])
    return servo


@pytest.fixture
def setpoint(standing: Array) -> Setpoint:
    zeros = np.zeros(len(standing) - BASE_COORDINATES)
    return Setpoint(standing[BASE_COORDINATES:].copy(), zeros.copy(), zeros.copy())


def changed(values: Array, joint: int, value: float) -> Array:
    after = values.copy()
    after[joint] = value
    return after


def test_it_starts_by_holding_where_the_joints_are(servo: Servo, robot: RobotModel, standing: Array) -> None:
    command = servo.command
    np.testing.assert_array_equal(command.position, standing[BASE_COORDINATES:])
    np.testing.assert_array_equal(command.stiffness, robot.stiffness)
    np.testing.assert_array_equal(command.damping, robot.damping)
    assert not command.velocity.any()
    assert not command.torque.any()


def test_a_setpoint_inside_the_limits_goes_through(servo: Servo, robot: RobotModel, setpoint: Setpoint) -> None:
    wanted = Setpoint(setpoint.position + 0.01, setpoint.velocity + 0.5, setpoint.torque - 3.0)
    assert servo.follow(wanted, PERIOD) == ""
    np.testing.assert_array_equal(servo.command.position, wanted.position)
    np.testing.assert_array_equal(servo.command.velocity, wanted.velocity)
    np.testing.assert_array_equal(servo.command.torque, wanted.torque)
    np.testing.assert_array_equal(servo.command.stiffness, robot.stiffness)
    assert not servo.limited.any()
    assert not servo.clamped


@pytest.mark.parametrize("bound", ["lower", "upper"])
def test_soft_limits_clamp_and_flag(servo: Servo, robot: RobotModel, setpoint: Setpoint, bound: str) -> None:
    joint = robot.joint("left_knee")
    limit = float(getattr(robot, bound)[joint])
    outside = limit + (0.02 if bound == "upper" else -0.02)
    servo.reset(changed(setpoint.position, joint, limit))
    servo.follow(replace(setpoint, position=changed(setpoint.position, joint, outside)), PERIOD)
    assert servo.command.position[joint] == limit
    assert np.flatnonzero(servo.limited).tolist() == [joint]
    assert servo.clamped


def test_a_solvers_overshoot_is_clamped_but_not_flagged(servo: Servo, robot: RobotModel, setpoint: Setpoint) -> None:
    joint = robot.joint("left_knee")
    position = changed(setpoint.position, joint, robot.upper[joint] + 1e-4)
    servo.reset(position)
    servo.follow(replace(setpoint, position=position), PERIOD)
    assert servo.command.position[joint] == robot.upper[joint]
    assert not servo.limited.any()


def test_setpoints_move_at_limited_speed(servo: Servo, robot: RobotModel, setpoint: Setpoint) -> None:
    joint = robot.joint("right_elbow")
    start, step = setpoint.position[joint], robot.speed_limit[joint] * PERIOD
    jump = replace(setpoint, position=changed(setpoint.position, joint, start - 0.5))
    servo.follow(jump, PERIOD)
    assert servo.command.position[joint] == pytest.approx(start - step)
    assert np.flatnonzero(servo.limited).tolist() == [joint]
    servo.follow(jump, PERIOD)
    assert servo.command.position[joint] == pytest.approx(start - 2 * step)


def test_what_is_in_force_and_comes_again_leaves_the_drives_their_command(servo: Servo, setpoint: Setpoint) -> None:
    servo.follow(setpoint, PERIOD)
    command, commands = servo.command, servo.commands
    assert servo.follow(setpoint, PERIOD) == ""
    assert servo.command is command
    assert servo.commands == commands + 1
    servo.damp()
    servo.follow(setpoint, PERIOD)
    assert servo.command.stiffness.any(), "the drives had let go meanwhile"


def test_a_setpoint_that_was_not_reached_for_its_speed_goes_on_by_less_than_is_flagged(
    servo: Servo, robot: RobotModel, setpoint: Setpoint
) -> None:
    joint = robot.joint("right_elbow")
    ahead = setpoint.position[joint] - robot.speed_limit[joint] * PERIOD - 1e-4
    wanted = replace(setpoint, position=changed(setpoint.position, joint, ahead))
    servo.follow(wanted, PERIOD)
    assert not servo.clamped
    servo.follow(wanted, PERIOD)
    assert servo.command.position[joint] == ahead


@pytest.mark.parametrize(("field", "limit"), [("velocity", "speed_limit"), ("torque", "torque_limit")])
def test_velocity_and_torque_are_limited(
    servo: Servo, robot: RobotModel, setpoint: Setpoint, field: str, limit: str
) -> None:
    joint = robot.joint("left_ankle_pitch")
    servo.follow(replace(setpoint, **{field: changed(setpoint.torque, joint, -1e4)}), PERIOD)
    assert getattr(servo.command, field)[joint] == -getattr(robot, limit)[joint]
    assert np.flatnonzero(servo.limited).tolist() == [joint]


@pytest.mark.parametrize("field", ["position", "velocity", "torque", "stiffness", "damping"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_what_is_not_finite_is_refused_and_the_last_setpoint_held(
    servo: Servo, setpoint: Setpoint, field: str, value: float
) -> None:
    good = Setpoint(setpoint.position + 0.01, setpoint.velocity + 0.5, setpoint.torque + 5.0)
    servo.follow(good, PERIOD)
    bad = replace(good, **{field: changed(setpoint.torque, 3, value)})
    assert servo.follow(bad, PERIOD) == "the setpoint is not finite"
    np.testing.assert_array_equal(servo.command.position, good.position)
    np.testing.assert_array_equal(servo.command.torque, good.torque)  # what carried the robot carries it still
    assert not servo.command.velocity.any()
    assert servo.follow(good, PERIOD) == ""


def test_what_is_soft_is_held_as_softly(servo: Servo, robot: RobotModel, setpoint: Setpoint) -> None:
    soft = replace(setpoint, stiffness=robot.stiffness * 0.2, damping=robot.damping * 0.5)
    servo.follow(soft, PERIOD)
    servo.hold()
    np.testing.assert_array_equal(servo.command.stiffness, soft.stiffness)
    np.testing.assert_array_equal(servo.command.damping, soft.damping)


@pytest.mark.parametrize("field", ["stiffness", "damping"])
def test_negative_gains_are_refused(servo: Servo, robot: RobotModel, setpoint: Setpoint, field: str) -> None:
    bad = replace(setpoint, **{field: changed(getattr(robot, field), 3, -1e-3)})
    assert servo.follow(bad, PERIOD) == "the setpoint has negative gains"
    np.testing.assert_array_equal(getattr(servo.command, field), getattr(robot, field))


def test_damping_lets_go_but_for_the_joints_friction(servo: Servo, robot: RobotModel, setpoint: Setpoint) -> None:
    servo.follow(replace(setpoint, torque=setpoint.torque + 1e4), PERIOD)
    servo.damp()
    command = servo.command
    assert not command.stiffness.any()
    assert not command.torque.any()
    assert not command.velocity.any()
    np.testing.assert_array_equal(command.damping, robot.damping)
    np.testing.assert_array_equal(command.position, setpoint.position)  # as a recording shows it
    assert not servo.limited.any()


def test_reset_clamps_into_the_limits_and_forgets(servo: Servo, robot: RobotModel, setpoint: Setpoint) -> None:
    servo.follow(replace(setpoint, torque=setpoint.torque + 1e4), PERIOD)
    servo.reset(robot.upper + 1.0)
    np.testing.assert_array_equal(servo.command.position, robot.upper)
    np.testing.assert_array_equal(servo.command.stiffness, robot.stiffness)
    assert not servo.clamped
    assert not servo.limited.any()
