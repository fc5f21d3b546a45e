"""Sensors that fail: silent, frozen, or saying what cannot be."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.control.estimator.sensor_limits import SensorLimits
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import SIDES, Array, Reading
from humanoid_bt.robot.model import RobotModel

_SILENT_AFTER, _FROZEN_AFTER = 3, 5  # looks: 15 and 25 ms; half of what is promised
_JUMPS_AFTER = {"gyro": 3, "accelerometer": 4, "orientation": 3}  # looks; one wrong reading jumps out and back
_SHAKEN = 1.2  # rad/s from look to look, of two joints: a blow, which an accelerometer feels; walking 0.5
_COMPARED_EVERY, _DRIFTS_AFTER = 2, 2  # looks; times that gyro and orientation disagree
_WRONG_AFTER = 2  # looks in which a joint says what cannot be
_FOOT_WRONG_AFTER, _FOOT_FORGET = 1.5, 0.1  # two of six looks: of what a sensor says at random, half may be borne
_FORGET = 0.5  # looks that another one in which nothing is seen takes off
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
        doubted: which of them are doubted now: an accelerometer that jumps wildly, an orientation or a gyroscope that
            jumps otherwise than the other one turns.
        bad_joints: whether each joint's sensors failed, or are doubted now, shape (nj,).
        any_bad: whether those of any did.
        bad_feet: whether a force sensor in a foot failed, or is doubted now.
        suspicious: whether something was seen lately of any sensor that may be a failure.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._names, self._limits = robot.joint_names, SensorLimits(robot)
        joints = len(self._names)
        self._before, self._moved = Reading(joints), Reading(joints)
        self._mean: Array = np.zeros(6)  # of what the IMU said between the last two looks
        self._leap: Array = np.zeros(6)  # how much that has changed
        self._still: Array = np.zeros(2)  # looks in which each foot has said the same
        self._counts: dict[tuple[str, str], float] = {}  # looks in which something was seen of a sensor
        self._wrong: Array = np.zeros(joints)  # such looks of each joint
        self._silent, self._frozen = np.zeros(joints, dtype=int), np.zeros(joints, dtype=int)
        self._dead = np.zeros(joints, dtype=bool)
        self.suspicious = False
        self._turned: Array = np.zeros((2, 3))  # by what the gyro says, since the orientation was compared with it
        self._turned_looks = 0
        self._compared: Array = np.zeros((2, 4))  # the orientation then; the second rows are of the time before
        self.bad_joints = np.zeros(joints, dtype=bool)
        self.any_bad = self.bad_feet = False
        self.failed: set[str] = set()
        self._failed_feet: set[str] = set()
        self.doubted: set[str] = set()
        self._found: list[str] = []  # what failed in this look, for people
        self.fault = ""
        limits = self._limits
        self._is_usual = _usual.bind(
            self._before.values, limits.most.values, limits.least, self._moved.values, self._mean, limits.most.imu,
            self._leap, limits.rates, self._turned[0], self._still, limits.feet,
        )  # fmt: skip
        self._disagree = _disagree.bind(self._compared, self._turned, limits.drift)

    def reset(self, reading: Reading) -> None:
        """Begin with sensors that work."""
        self._counts.clear()
        for array in (self._silent, self._frozen, self._wrong, self._dead, self.bad_joints, self._still):
            array[:] = 0
        self.suspicious = False
        self.failed.clear()
        self._failed_feet.clear()
        self._found.clear()
        self.fault = ""
        self.resume(reading, reading.rates)

    def resume(self, reading: Reading, rates: Array) -> None:
        """Go on after readings were missed: this one is compared with the next.

        Args:
            reading: the last one.
            rates: as in :meth:`look`.
        """
        self._before.values[:] = reading.values
        self._mean[:] = rates[:6]
        for _ in range(2):  # this time and the time before
            _compare_from(reading.orientation, self._compared, self._turned)
        self._turned_looks = 0
        self.doubted.clear()
        self._doubt_joints(self._silent_joints(reading, rates) | self._wrong_joints(reading, rates, 0.0))
        self._doubt_feet(reading)
        self.suspicious = self.suspicious or self.any_bad or self.bad_feet

    def look(self, reading: Reading, rates: Array, time: float, upright: bool) -> None:
        """Judge a reading, of those that are 5 ms apart, or twice as much.

        Args:
            reading: the last one.
            rates: those of all readings since the one before, on average.
            time: since then [s].
            upright: whether the robot stands or walks; one that falls is thrown about, and so are its sensors.
        """
        usual = self._is_usual(reading.values, rates, time)
        if self.suspicious or not usual:
            self._look_closer(reading, rates, time, upright)
        self._before.values[:] = reading.values
        self._compare(reading, upright)
        if self._found:
            self.fault = self.fault or _together(self._found)
            self._found.clear()

    def _look_closer(self, reading: Reading, rates: Array, time: float, upright: bool) -> None:
        shaken = bool(np.partition(self._moved.joint_velocity, -2)[-2] > _SHAKEN)
        turned_so = self._turned_so(reading, rates, time)
        struck = shaken and "accelerometer" not in self.doubted  # one that fails shakes the joints itself
        felt = {"accelerometer": struck, "gyro": shaken and turned_so, "orientation": turned_so}  # a blow, no failure
        heard = {"accelerometer": rates[:3], "gyro": rates[3:6], "orientation": reading.orientation}
        for name in _IMU:
            moved, most = getattr(self._moved, name), getattr(self._limits.most, name)
            silent = not math.isfinite(heard[name].sum())
            self._count(self.failed, name, "is silent", silent, _SILENT_AFTER)
            frozen = name in self._limits.flickers and not moved.any()
            self._count(self.failed, name, "is frozen", frozen, _FROZEN_AFTER)
            jumps = bool((moved > most).any()) and upright and not felt[name]
            self._count(self.failed, name, "jumps", jumps, _JUMPS_AFTER[name])
        self._doubt_imu(turned_so, shaken, upright)
        self._look_at_joints(reading, rates, time, upright)
        if self._limits.feels:
            self._look_at_feet(reading, upright)
        counted = bool(self._counts) or any(looks.any() for looks in (self._silent, self._frozen, self._wrong))
        self.suspicious = counted or bool(self.doubted) or self.any_bad or self.bad_feet

    def _doubt_imu(self, turned_so: bool, shaken: bool, upright: bool) -> None:
        """Doubt at once what throws the estimate about, also where a single reading between two looks does."""
        moved, most = self._moved, self._limits.most
        jumps = np.maximum(moved.imu, self._leap)
        counted, wild = ("accelerometer", "jumps") in self._counts, jumps[:3].max() > self._limits.wild
        differ = upright and not turned_so and "orientation" not in self.failed
        doubts = {
            "accelerometer": (wild and (counted or (upright and not shaken)))
            or (counted and "accelerometer" in self.doubted),
            "orientation": differ and (moved.orientation > most.orientation).any(),
            "gyro": differ and (jumps[3:] > most.gyro).any(),
        }
        self.doubted = {name for name, doubtful in doubts.items() if doubtful}

    def _turned_so(self, reading: Reading, rates: Array, time: float) -> bool:
        """Return whether the orientation has turned since the last look as the gyro says."""
        return _disagreement(self._before.orientation, reading.orientation, rates[3:6] * time) < self._limits.same

    def _compare(self, reading: Reading, upright: bool) -> None:
        """Compare now and then how the orientation has turned with what the gyro says.

        A single wrong orientation turns out and back: with the time before, it has not turned.
        """
        self._turned_looks += 1
        if self._turned_looks < _COMPARED_EVERY:
            return
        self._turned_looks = 0
        off = self._disagree(reading.orientation)
        if upright and not self.failed:
            self._count(self.failed, "gyro", "says something else than the orientation", off, _DRIFTS_AFTER)

    def _count(self, failed: set[str], name: str, how: str, seen: bool, most: float, forget: float = _FORGET) -> None:
        """Count the looks in which something was seen, a part of the others off; it has failed if that is much."""
        key = name, how
        if not seen:
            if key in self._counts and (count := self._counts.pop(key)) > forget:
                self._counts[key] = count - forget
            return
        self._counts[key] = count = self._counts.get(key, 0.0) + 1.0
        if count >= most and name not in failed:
            failed.add(name)
            self._found.append(f"the {name} {how}")

    def _look_at_feet(self, reading: Reading, upright: bool) -> None:
        least, most, never_still = self._limits.feet.tolist()
        for side, force, still in zip(SIDES, reading.foot_force.tolist(), self._still.tolist(), strict=True):
            name, silent = f"force sensor of the {side} foot", not math.isfinite(force)
            self._count(self._failed_feet, name, "is silent", silent, _SILENT_AFTER)
            self._count(self._failed_feet, name, "is frozen", still >= never_still, 1)
            wrong = upright and (force <= least or force >= most)
            self._count(self._failed_feet, name, "says what no foot bears", wrong, _FOOT_WRONG_AFTER, _FOOT_FORGET)
        self._doubt_feet(reading)

    def _doubt_feet(self, reading: Reading) -> None:
        least, most, _ = self._limits.feet.tolist()
        can_be = all(least < force < most for force in reading.foot_force.tolist())  # no, if it is not finite
        self.bad_feet = self._limits.feels and (bool(self._failed_feet) or not can_be)

    def _silent_joints(self, reading: Reading, rates: Array) -> NDArray[np.bool_]:
        """Return of which joints something was not said, shape (nj,)."""
        torques = rates[-len(self._names) :]
        return np.asarray(~np.isfinite(reading.joint_position + reading.joint_velocity + torques))

    def _wrong_joints(self, reading: Reading, rates: Array, turned: Array | float) -> NDArray[np.bool_]:
        """Return which joints say a speed or torque that cannot be, shape (nj,).

        Args:
            reading, rates: as in :meth:`look`.
            turned: how fast they have turned at most by their angles [rad/s]: so fast they can be.
        """
        speeds, torques = np.maximum(np.abs(reading.rates[6:]), np.abs(rates[6:])).reshape(2, -1)
        most_speeds, most_torques = self._limits.rates.reshape(2, -1)
        return np.asarray((speeds > np.maximum(most_speeds, turned)) | (torques > most_torques))

    def _doubt_joints(self, doubtful: NDArray[np.bool_]) -> None:
        np.logical_or(self._dead, doubtful, out=self.bad_joints)
        self.any_bad = bool(self.bad_joints.any())

    def _look_at_joints(self, reading: Reading, rates: Array, time: float, upright: bool) -> None:
        moved, most = self._moved, self._limits.most.joint_position
        silent = self._silent_joints(reading, rates)
        wrong = self._wrong_joints(reading, rates, (moved.joint_position + most) / time)
        same = (moved.joint_position == 0) & (moved.joint_velocity == 0) & (moved.joint_torque == 0)
        speeds = np.maximum(np.abs(self._before.joint_velocity), np.abs(reading.joint_velocity))  # in a blow, high
        jumped = (moved.joint_position > speeds * time + most) & ~silent & upright
        self._silent[:] = (self._silent + 1) * silent
        self._frozen[:] = (self._frozen + 1) * (same & ("joints" in self._limits.flickers))
        self._wrong[:] = np.where(wrong & upright, self._wrong + 1.0, np.maximum(self._wrong - _FORGET, 0.0))
        for joints, how in (
            (self._silent >= _SILENT_AFTER, "are silent"),
            (self._frozen >= _FROZEN_AFTER, "are frozen"),
            (self._wrong >= _WRONG_AFTER, "say what cannot be"),
            (jumped, "jumped"),
        ):
            for joint in np.flatnonzero(joints & ~self._dead):
                self._found.append(f"the sensors of {self._names[joint]} {how}")
            self._dead |= joints
        self._doubt_joints(silent | wrong)


@bindable(
    "b1(f8[::1], f8[::1], f8)",
    "f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1]",
)
def _usual(
    values: Array,
    rates: Array,
    time: float,
    before: Array,
    most: Array,
    least: Array,
    moved: Array,
    mean: Array,
    most_leap: Array,
    leap: Array,
    most_rates: Array,
    turned: Array,
    still: Array,
    foot_limits: Array,
) -> bool:
    """Return whether every number can be, and has changed by no more than the most and by more than the least.

    One axis of a gyroscope or accelerometer often says the same twice, as they tell no finer steps; all three do not.

    Args:
        values: of this look.
        rates: of the readings since the last one, on average: specific force, angular velocity, joints.
        time: since then [s].
        before: what values were then.
        most, least: what is usual.
        moved: is written: how much each has changed.
        mean: those of the IMU before; becomes the ones now.
        most_leap: by which these usually change.
        leap: is written: how much they have.
        most_rates: the largest speeds and torques of joints, shape (2 nj,).
        turned: how far the angular velocity has turned the base is added to it.
        still: looks in which each foot has said the same.
        foot_limits: the least and the most that a foot bears [N], and how often it does not say the same.
    """
    usual = True
    for place in range(len(values)):
        way = abs(values[place] - before[place])
        moved[place] = way
        usual = usual and way <= most[place] and way > least[place]  # false also of what is not finite
    for place in range(6):
        way = abs(rates[place] - mean[place])
        leap[place] = way
        mean[place] = rates[place]
        usual = usual and way <= most_leap[place]
    first = len(values) - len(most_rates)
    for sensor in (first - 6, first - 3):
        usual = usual and moved[sensor] + moved[sensor + 1] + moved[sensor + 2] > 0
    for place in range(len(most_rates)):
        most_rate = most_rates[place]
        usual = usual and abs(rates[6 + place]) <= most_rate and abs(values[first + place]) <= most_rate
    for foot in range(2):
        still[foot] = still[foot] + 1 if moved[foot] == 0 else 0
        usual = usual and foot_limits[0] < values[foot] < foot_limits[1] and still[foot] < foot_limits[2]
    for axis in range(3):
        turned[axis] += rates[3 + axis] * time
    return usual


def _together(found: list[str]) -> str:
    """Return what failed at the same time as one text."""
    for how in ("is silent", "is frozen", "jumps"):
        alone = [f"the {name} {how}" for name in _IMU]
        if set(alone) <= set(found):
            found = [f"the whole IMU {how}", *(one for one in found if one not in alone)]
    more = len(found) - _MOST_NAMED
    return ", ".join(found[:_MOST_NAMED]) + (f", and {more} more" if more > 0 else "")


@compiled("f8(f8[::1], f8[::1], f8[::1])")
def _disagreement(before: Array, after: Array, said: Array) -> float:
    """Return by how much two orientations are turned otherwise than somebody says, about the worst axis [rad].

    Args:
        before, after: quaternions, for small turns, shape (4,).
        said: rotation vector from one to the other, in the body's frame, shape (3,) [rad].
    """
    w, x, y, z = before[0], before[1], before[2], before[3]
    a, b, c, d = after[0], after[1], after[2], after[3]
    length = math.sqrt((w * w + x * x + y * y + z * z) * (a * a + b * b + c * c + d * d))
    share = math.copysign(2.0, w * a + x * b + y * c + z * d) / (length if length else 1.0)
    turn = (w * b - x * a - y * d + z * c, w * c + x * d - y * a - z * b, w * d - x * c + y * b - z * a)
    most = 0.0
    for axis in range(3):
        off = abs(share * turn[axis] - said[axis])
        if off > most or not math.isfinite(off):
            most = off
    return most


@compiled("void(f8[::1], f8[:, ::1], f8[:, ::1])")
def _compare_from(orientation: Array, compared: Array, turned: Array) -> None:
    """Compare with an orientation from now on; see :func:`_disagree`."""
    turned[1], compared[1] = turned[0], compared[0]
    turned[0], compared[0] = 0.0, orientation


@bindable("b1(f8[::1])", "f8[:, ::1], f8[:, ::1], f8")
def _disagree(orientation: Array, compared: Array, turned: Array, most: float) -> bool:
    """Return whether an orientation has turned otherwise than the gyro says since the last two were compared with it.

    Args:
        orientation: which the next one is compared with, shape (4,).
        compared: the last one and the one before, shape (2, 4).
        turned: how far the gyro says that the base has turned since the last one, and between the two, rotation
            vectors, shape (2, 3) [rad].
        most: by more than that it is otherwise [rad].
    """
    off = _disagreement(compared[0], orientation, turned[0]) > most and (
        _disagreement(compared[1], orientation, turned[1] + turned[0]) > most
    )
    _compare_from(orientation, compared, turned)
    return off
