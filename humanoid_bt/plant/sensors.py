"""The simulated sensors of a robot: what is true, with noise, bias, resolution and delay."""

from __future__ import annotations

import math
from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.clock import SERVO_PERIOD, cycles
from humanoid_bt.core.messages import Array, Reading
from humanoid_bt.plant.sensor_failures import FAILURES, FOOT_SENSORS
from humanoid_bt.robot.sensor_config import SensorsConfig

_BLOCK = 25  # servo cycles for which noise is drawn at once
_FINEST = 1e-12  # stands for the resolution of a sensor that is said to have none

_JUMPS = {"gyro": 10.0, "accelerometer": 100.0, "orientation": 0.5, "joint": 0.5}  # as far as they jump
_JUMPS |= dict.fromkeys(FOOT_SENSORS, 5000.0)


class Sensors:
    """What the sensors say, a while after it was so.

    Args:
        config: what they are like.
        model, data: MuJoCo's, of the robot in its scene; the robot's coordinates come first.
        joints: how many the robot has.
        feet: where MuJoCo's ``sensordata`` has what the (left, right) foot bears, of either sign [N].

    Attributes:
        encoder_error: what each encoder is off besides that, from the next :meth:`reset` on, shape (nj,) [rad].
        encoder_bias: what each joint's zero is off now, shape (nj,) [rad]; the drive's control sees it, too.
    """

    def __init__(
        self, config: SensorsConfig, model: mujoco.MjModel, data: mujoco.MjData, joints: int, feet: Sequence[int]
    ) -> None:
        self._config, self._joints = config, joints
        self._velocity_now = data.qvel[: 6 + joints]
        self._joint_positions = slice(6, 6 + joints)
        self._imu = {"orientation": slice(2, 6), "accelerometer": slice(6 + joints, 9 + joints)}
        self._imu["gyro"] = slice(9 + joints, 12 + joints)
        feels = config.foot_force is not None
        self._soles = {name: slice(foot, foot + 1) for foot, name in enumerate(FOOT_SENSORS) if feels}
        self._noise, self._bias, resolution = self._described()
        self._delay = cycles(config.delay)
        self._rows = np.zeros((self._delay + 1, len(self._noise)))
        self._velocity: Array = np.zeros(6 + joints)
        self._random = np.random.default_rng(0)
        self._offset: Array = np.zeros(len(self._noise))
        self._drift = 0.0
        self._tilt = 0.0, 0.0
        self.encoder_error, self.encoder_bias = np.zeros(joints), np.zeros(joints)
        self._count = 0
        self._failures: dict[str, tuple[slice | list[int], str]] = {}
        self._last: Array = self._rows[0].copy()
        self._errors: Array = np.zeros((_BLOCK, len(self._noise)))
        turned = np.eye(4)
        self._turn = _turn.bind(turned)
        self._sense = _sense.bind(
            self._rows, data.sensordata, np.array(feet if feels else [], np.int64), data.qpos[3 : 7 + joints],
            self._velocity_now, self._velocity, data.actuator_force, model.actuator_forcerange, model.actuator_biasprm,
            turned, -float(model.opt.gravity[2]), self._errors, self._noise, self._offset,
            np.maximum(resolution, _FINEST),
        )  # fmt: skip
        self._read = _read.bind(self._rows)

    def _described(self) -> tuple[Array, Array, Array]:
        """Return the standard deviations of noise and bias and the resolution of every number."""
        config = self._config
        noise, bias, resolution = Reading(self._joints), Reading(self._joints), Reading(self._joints)
        for name, sensor in (("gyro", config.gyro), ("accelerometer", config.accelerometer)):
            getattr(noise, name)[:] = sensor.noise
            getattr(bias, name)[:] = sensor.bias
            getattr(resolution, name)[:] = sensor.resolution
        noise.orientation[:] = config.orientation.noise / 2  # of a quaternion's numbers
        if config.foot_force is not None:
            noise.foot_force[:], bias.foot_force[:] = config.foot_force.noise, config.foot_force.bias
            resolution.foot_force[:] = config.foot_force.resolution
        encoders = config.encoders
        noise.joint_position[:], bias.joint_position[:] = encoders.noise, encoders.bias
        resolution.joint_position[:] = encoders.resolution
        noise.joint_velocity[:] = encoders.speed_noise
        noise.joint_torque[:], bias.joint_torque[:] = encoders.torque_noise, encoders.torque_bias
        return noise.values, bias.values, resolution.values

    def reset(self, random: np.random.Generator) -> None:
        """Begin a run with a robot at rest: what is off is drawn anew."""
        self._random = random
        self._offset[:] = random.standard_normal(len(self._offset)) * self._bias
        self.encoder_bias = self._offset[self._joint_positions]
        self.encoder_bias += self.encoder_error
        tilt = self._config.orientation.bias
        roll, pitch = (tilt * random.standard_normal(2)).tolist()
        self._tilt = roll, pitch
        self._drift = float(random.standard_normal()) * self._config.orientation.drift
        self._count = 0
        self._failures.clear()
        self._velocity[:] = self._velocity_now
        for _ in self._rows:
            self.sense()

    def sense(self) -> None:
        """Measure what is true now; call it once a servo cycle."""
        count = self._count
        if count % _BLOCK == 0:
            self._random.standard_normal(out=self._errors)
            self._turn(*self._tilt, self._drift * count * SERVO_PERIOD)
        self._sense(count)
        self._count = count + 1
        if self._failures:
            self._spoil(self._rows[count % len(self._rows)])

    def fail(self, sensor: str, how: str, joints: Sequence[str]) -> None:
        """Let a sensor fail until :meth:`reset`.

        Args:
            sensor: "gyro", "accelerometer", "orientation", "imu" for all three, "left_foot" or "right_foot" if it has
                force sensors there, or a joint.
            how: one of :data:`FAILURES`.
            joints: the robot's.

        Raises:
            ValueError: there is no such sensor, or it cannot fail so.
        """
        self._last = self._rows[(self._count - 1) % len(self._rows)].copy()
        if how not in FAILURES:
            raise ValueError(f"a sensor cannot fail {how!r}; valid: {', '.join(FAILURES)}")
        places = self._imu | self._soles
        if sensor in joints:
            first, count = joints.index(sensor), len(joints)
            self._failures[sensor] = [6 + first, 12 + count + first, 12 + 2 * count + first], how
        elif sensor == "imu":
            self._failures |= {name: (place, how) for name, place in self._imu.items()}
        elif sensor in places:
            self._failures[sensor] = places[sensor], how
        else:
            raise ValueError(f"there is no sensor {sensor!r}; valid: imu, {', '.join((*places, *joints))}")

    def _spoil(self, row: Array) -> None:
        for name, (place, how) in self._failures.items():
            if how == "frozen":
                row[place] = self._last[place]
            elif how == "silent":
                row[place] = np.nan
            else:
                far = _JUMPS.get(name, _JUMPS["joint"])
                row[place] += self._random.uniform(-far, far, len(row[place]))

    def read(self, into: Reading) -> None:
        """Copy what they say now, which was so a while ago."""
        self._read(self._count, into.values)


@bindable("void(f8, f8, f8)", "f8[:, ::1]")
def _turn(roll: float, pitch: float, yaw: float, turned: Array) -> None:
    """Write the matrix, shape (4, 4), that turns a quaternion by a small tilt, and then about the vertical [rad]."""
    w, z = math.cos(yaw / 2), math.sin(yaw / 2)
    x, y = (w * roll - z * pitch) / 2, (w * pitch + z * roll) / 2
    turned[0, 0], turned[0, 1], turned[0, 2], turned[0, 3] = w, -x, -y, -z
    turned[1, 0], turned[1, 1], turned[1, 2], turned[1, 3] = x, w, -z, y
    turned[2, 0], turned[2, 1], turned[2, 2], turned[2, 3] = y, z, w, -x
    turned[3, 0], turned[3, 1], turned[3, 2], turned[3, 3] = z, -y, x, w


@bindable(
    "void(i8)",
    "f8[:, ::1], f8[::1], i8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[:, ::1], f8[:, ::1], f8[:, ::1], f8,"
    " f8[:, ::1], f8[::1], f8[::1], f8[::1]",
)
def _sense(
    count: int,
    rows: Array,
    forces: Array,
    feet: NDArray[np.int64],
    pose: Array,
    velocity: Array,
    before: Array,
    torques: Array,
    limits: Array,
    drives: Array,
    turned: Array,
    gravity: float,
    errors: Array,
    noise: Array,
    offset: Array,
    finest: Array,
) -> None:
    """Write what the sensors say in the order of :class:`~humanoid_bt.core.messages.Reading`; note the velocity.

    Args:
        count: of servo cycles before; the next one of the rows is written, with the next one of the errors.
        rows: of what the sensors say.
        forces, feet: MuJoCo's sensors, and where among them is what each foot bears, of either sign [N]; nowhere if no
            sensor says it.
        pose: quaternion of the base, and the joints, shape (4 + nj,).
        velocity: of the base, world frame, [m/s], its angular velocity in its own frame, and that of the joints
            [rad/s], shape (6 + nj,).
        before: the velocity a servo period ago; becomes the one now.
        torques: of the joints as MuJoCo's step began, shape (nj,) [Nm]. It integrates implicitly: what the joints got
            is what their drives give for the velocity with which it ended.
        limits: of these torques, least and most, shape (nj, 2) [Nm].
        drives: MuJoCo's parameters of each joint's drive; the third is the torque for its velocity [Nm s/rad].
        turned: turns a quaternion by what the IMU's own filter is off, shape (4, 4).
        gravity: upward [m/s^2].
        errors: rows of random numbers.
        noise, offset, finest: of every number the standard deviation, what it is off, and its resolution.
    """
    joints, row, error = len(torques), rows[count % len(rows)], errors[count % len(errors)]
    force = 6 + joints
    for i in range(joints):
        row[6 + i] = pose[4 + i]
        row[6 + force + joints + i] = torques[i]
        if limits[i, 0] < torques[i] < limits[i, 1]:
            row[6 + force + joints + i] += drives[i, 2] * (velocity[6 + i] - before[6 + i])
    row[:2] = 0.0
    for foot in range(len(feet)):
        row[foot] = abs(forces[feet[foot]])
    for i in range(4):
        row[2 + i] = turned[i, 0] * pose[0] + turned[i, 1] * pose[1] + turned[i, 2] * pose[2] + turned[i, 3] * pose[3]
    a = (velocity[0] - before[0]) / SERVO_PERIOD
    b = (velocity[1] - before[1]) / SERVO_PERIOD
    c = (velocity[2] - before[2]) / SERVO_PERIOD + gravity
    before[:] = velocity
    w, x, y, z = pose[0], pose[1], pose[2], pose[3]  # which turns the base into the world; the force, back
    u, v, t = 2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)
    row[force] = a - w * u + y * t - z * v
    row[force + 1] = b - w * v + z * u - x * t
    row[force + 2] = c - w * t + x * v - y * u
    row[force + 3 : 6 + force] = velocity[3:6]
    row[6 + force : 6 + force + joints] = velocity[6:]
    for i in range(len(row)):
        row[i] = np.rint((row[i] + (error[i] * noise[i] + offset[i])) / finest[i]) * finest[i]


@bindable("void(i8, f8[::1])", "f8[:, ::1]")
def _read(count: int, values: Array, rows: Array) -> None:
    """Write what the sensors said first of all that the rows have, after so many servo cycles."""
    values[:] = rows[count % len(rows)]
