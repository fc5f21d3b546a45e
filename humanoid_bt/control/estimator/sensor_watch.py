"""Sensors that fail: silent, frozen, or saying what cannot be."""

from __future__ import annotations

import math
import sys

import numpy as np

from humanoid_bt.core.clock import ESTIMATE_PERIOD
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import Array, Reading
from humanoid_bt.robot.model import RobotModel

_SILENT_AFTER, _FROZEN_AFTER = 3, 5  # looks: 15 and 25 ms; half of what is promised
_JUMPS_AFTER = {"gyro": 2, "accelerometer": 4, "orientation": 2}  # looks in which it jumps: a blow rings for two
_SHAKEN = 1.2  # rad/s from look to look, of two joints: a blow, which an accelerometer feels; walking 0.5
_GYRO_JUMP, _ACCELEROMETER_JUMP, _ORIENTATION_JUMP = 4.0, 25.0, 0.1  # from look to look; walking: 0.5, 4 and 0.01
_WILD = 50.0  # m/s^2 from look to look, more than of feet that land hard: the accelerometer is doubted at once
_DRIFT, _DRIFTS_AFTER = 0.03, 2  # rad that gyro and orientation disagree in two looks, and how often
_COMPARED_EVERY = 2  # looks
_SAME = 0.006  # rad that they may disagree in one look in which a blow makes the gyro jump
_FORGET = 0.5  # looks that another one in which nothing is seen takes off
_SPEEDS, _SLACK = 2.0, 0.03  # times its limit that a joint may be fast, and rad beside that
_IMU = ("gyro", "accelerometer", "orientation")
_MOST_NAMED = 4  # of what failed at the same time


class SensorWatch:
    """Looks at every reading that the body is controlled with, at 200 Hz. What failed once is not believed again.

    A frozen sensor is found by its noise: one that has none, by its configuration, may say the same for ever.

    Args:
        robot: the robot.

    Attributes:
        fault: what failed first, and what else at the same time, for people; "" while nothing has.
        failed: which of the IMU's sensors failed.
        bad_joints: whether each joint's sensors failed, or are doubted now, shape (nj,).
        any_bad: whether those of any did.
        suspicious: whether something was seen lately of any sensor that may be a failure.
        accelerometer_doubtful: whether that was a wild jump of the accelerometer.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._names = robot.joint_names
        joints, sensors = len(robot.joint_names), robot.config.sensors
        self._imu_flickers = {
            "gyro": sensors.gyro.noise > sensors.gyro.resolution,
            "accelerometer": sensors.accelerometer.noise > sensors.accelerometer.resolution,
            "orientation": sensors.orientation.noise > 0,
        }
        self._joints_flicker = sensors.encoders.torque_noise > 0 and sensors.encoders.speed_noise > 0
        self._before, self._moved, self._most = Reading(joints), Reading(joints), Reading(joints)
        self._most.values[:] = sys.float_info.max  # that a number may change from look to look
        self._most.gyro[:], self._most.accelerometer[:] = _GYRO_JUMP, _ACCELEROMETER_JUMP
        self._most.orientation[:] = _ORIENTATION_JUMP / 2  # of a quaternion's numbers
        self._most.joint_position[:] = _SPEEDS * robot.speed_limit * ESTIMATE_PERIOD + _SLACK
        least = Reading(joints)  # IMU, speeds, torques: they hardly ever say the same twice
        least.values[:] = -1.0
        least.values[6 + joints :] = least.orientation[:] = 0.0
        self._least = least.values
        self._counts: dict[tuple[str, str], float] = {}  # looks in which something was seen of a sensor
        self._silent, self._frozen = np.zeros(joints, dtype=int), np.zeros(joints, dtype=int)
        self._dead = np.zeros(joints, dtype=bool)
        self.suspicious = self.accelerometer_doubtful = False
        self._turned: Array = np.zeros(3)  # by what the gyro says, since the orientation was compared with it
        self._turned_looks = 0
        self._compared = self._before.orientation.tolist()
        self.bad_joints = np.zeros(joints, dtype=bool)
        self.any_bad = False
        self.failed: set[str] = set()
        self._found: list[str] = []  # what failed in this look, for people
        self.fault = ""

    def reset(self, reading: Reading) -> None:
        """Begin with sensors that work."""
        self._before.values[:] = reading.values
        self._counts.clear()
        for joints in (self._silent, self._frozen, self._dead, self.bad_joints):
            joints[:] = 0
        self.suspicious = self.accelerometer_doubtful = self.any_bad = False
        self._compare_from(reading)
        self.failed.clear()
        self._found.clear()
        self.fault = ""

    def resume(self, reading: Reading) -> None:
        """Go on after readings were missed: this one is compared with the next."""
        self._before.values[:] = reading.values
        self._compare_from(reading)

    def look(self, reading: Reading, imu: Array, time: float, upright: bool) -> None:
        """Judge a reading, of those that are 5 ms apart, or twice as much.

        Args:
            reading: the last one.
            imu: specific force and rate, on average since the one before, shape (6,).
            time: since then [s].
            upright: whether the robot stands or walks; one that falls is thrown about, and so are its sensors.
        """
        values, before = reading.values, self._before.values
        usual = _usual(values, before, self._most.values, self._least, self._moved.values, imu, time, self._turned)
        if self.suspicious or not usual:
            self._look_closer(reading, imu, time, upright)
        before[:] = values
        self._compare(reading, upright)
        if self._found:
            self.fault = self.fault or _together(self._found)
            self._found.clear()

    def _look_closer(self, reading: Reading, imu: Array, time: float, upright: bool) -> None:
        shaken = np.partition(self._moved.joint_velocity, -2)[-2] > _SHAKEN
        felt = {
            "accelerometer": shaken,
            "gyro": shaken and self._turned_so(reading, imu, time),
        }  # a blow, not a failure
        for name in _IMU:
            moved, most = getattr(self._moved, name), getattr(self._most, name)
            silent = not math.isfinite(getattr(reading, name).sum())
            self._count(name, "is silent", silent, _SILENT_AFTER)
            self._count(name, "is frozen", self._imu_flickers[name] and not moved.any(), _FROZEN_AFTER)
            jumps = bool((moved > most).any()) and upright and not felt.get(name)
            self._count(name, "jumps", jumps, _JUMPS_AFTER[name])
        self._look_at_joints(reading, upright)
        wild = bool(self._moved.accelerometer.max() > _WILD)
        self.accelerometer_doubtful = ("accelerometer", "jumps") in self._counts and (
            wild or self.accelerometer_doubtful
        )
        self.suspicious = bool(self._counts) or bool(self._silent.any() or self._frozen.any() or self.any_bad)

    def _turned_so(self, reading: Reading, imu: Array, time: float) -> bool:
        """Return whether the orientation has turned since the last look as the gyro says."""
        turned = _turn(self._before.orientation.tolist(), reading.orientation.tolist())
        rates = imu[3:].tolist()
        return all(abs(way - rate * time) < _SAME for way, rate in zip(turned, rates, strict=True))

    def _compare(self, reading: Reading, upright: bool) -> None:
        """Compare now and then how the orientation has turned with what the gyro says."""
        self._turned_looks += 1
        if self._turned_looks < _COMPARED_EVERY:
            return
        if upright and not self.failed:
            turned = _turn(self._compared, reading.orientation.tolist())
            off = max(abs(one - other) for one, other in zip(turned, self._turned.tolist(), strict=True))
            self._count("gyro", "says something else than the orientation", off > _DRIFT, _DRIFTS_AFTER)
        self._compare_from(reading)

    def _compare_from(self, reading: Reading) -> None:
        self._turned[:] = 0.0
        self._turned_looks = 0
        self._compared = reading.orientation.tolist()

    def _count(self, name: str, how: str, seen: bool, most: float) -> None:
        """Count the looks in which something was seen, half as many others off; take it for a failure if it is much."""
        key = name, how
        if not seen:
            if key in self._counts and (count := self._counts.pop(key)) > _FORGET:
                self._counts[key] = count - _FORGET
            return
        self._counts[key] = count = self._counts.get(key, 0.0) + 1.0
        if count >= most and name not in self.failed:
            self.failed.add(name)
            self._found.append(f"the {name} {how}")

    def _look_at_joints(self, reading: Reading, upright: bool) -> None:
        moved = self._moved
        silent = ~np.isfinite(reading.joint_position + reading.joint_velocity + reading.joint_torque)
        same = (moved.joint_position == 0) & (moved.joint_velocity == 0) & (moved.joint_torque == 0)
        jumped = (moved.joint_position > self._most.joint_position) & ~silent & upright
        self._silent[:] = (self._silent + 1) * silent
        self._frozen[:] = (self._frozen + 1) * (same & self._joints_flicker)
        for joints, how in (
            (self._silent >= _SILENT_AFTER, "are silent"),
            (self._frozen >= _FROZEN_AFTER, "are frozen"),
            (jumped, "jumped"),
        ):
            for joint in np.flatnonzero(joints & ~self._dead):
                self._found.append(f"the sensors of {self._names[joint]} {how}")
            self._dead |= joints
        np.logical_or(self._dead, silent, out=self.bad_joints)
        self.any_bad = bool(self.bad_joints.any())


@compiled("b1(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8, f8[::1])")
def _usual(
    values: Array, before: Array, most: Array, least: Array, moved: Array, imu: Array, time: float, turned: Array
) -> bool:
    """Return whether every number has changed by no more than the most and by more than the least.

    Args:
        values, before: of two looks.
        most, least: what is usual.
        moved: is written: how much each has changed.
        imu: specific force and rate, on average between the looks.
        time: between them [s].
        turned: how far that has turned the base is added to it.
    """
    usual = True
    for place in range(len(values)):
        way = abs(values[place] - before[place])
        moved[place] = way
        usual = usual and way <= most[place] and way > least[place]  # false also of what is not finite
    for axis in range(3):
        turned[axis] += imu[3 + axis] * time
    return usual


def _together(found: list[str]) -> str:
    """Return what failed at the same time as one text."""
    for how in ("is silent", "is frozen", "jumps"):
        alone = [f"the {name} {how}" for name in _IMU]
        if set(alone) <= set(found):
            found = [f"the whole IMU {how}", *(one for one in found if one not in alone)]
    more = len(found) - _MOST_NAMED
    return ", ".join(found[:_MOST_NAMED]) + (f", and {more} more" if more > 0 else "")


def _turn(before: list[float], after: list[float]) -> list[float]:
    """Return the rotation vector from one quaternion to another, in the body's frame, for small turns [rad]."""
    w, x, y, z = before
    a, b, c, d = after
    sign = 2.0 if w * a + x * b + y * c + z * d >= 0 else -2.0
    turn = (w * b - x * a - y * d + z * c, w * c + x * d - y * a - z * b, w * d - x * c + y * b - z * a)
    return [sign * part for part in turn]
