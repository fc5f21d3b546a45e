"""Readings in, at 1 kHz; an estimate of the robot out, at 200 Hz."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from humanoid_bt.control.body.planar import middle
from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.control.estimator.contact_observer import ContactObserver
from humanoid_bt.control.estimator.foot_load import FootLoad
from humanoid_bt.control.estimator.ground import Ground
from humanoid_bt.control.estimator.invariant_filter import FREE, FilterNoise, InvariantFilter
from humanoid_bt.control.estimator.sensor_watch import SensorWatch
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.geometry import clamp, yaw_of
from humanoid_bt.core.messages import Array, Estimate, Reading
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel

_TURNS = 3  # updates from one correction to the next
_STILL_AFTER = 0.3  # s on both feet after which soles no longer roll
_STILL = 0.1  # of the slip of a sole that rolls
_ROLLING = 10.0  # times the slip of a loaded sole: one that lifts off, or carries little
_ROLLS_BELOW = 0.5  # share of the weight
_SLIDES = 0.15  # m/s of a sole on the ground above which it slides, and says nothing of where the base is
_SLIDES_FOR = 0.3  # s after which it is not the sole that is wrong
_LANDS = 0.015  # s in which a sole that has met the ground may slide on it
_LEVEL_SHARE = 1.0  # of what the legs say of the base's tilt that is believed in a period
_SAID_SHARE = 0.5  # of what the orientation says of the base's turning that is believed in a period
_RATE_SHARE = 0.2  # of what the legs say of the base's turning that is believed in a period
_DOUBTED_MOST = 10.0  # m/s^2 that an accelerometer may say more or less than before, while it is doubted
_LEGS_SHARE = 0.3  # of what the legs say of its velocity that is believed in a period, without an accelerometer
_LEGS_MOST = 0.15  # m/s of it at most: a sole that hits the ground, or slides, says less
_STEADY = 0.5  # s upright after which nothing throws the robot about any more
_SURELY_UPRIGHT = 0.95  # cosine of the base's tilt, 18 degrees
_LONGEST_GAP = 3  # servo periods without a reading after which torques are known too badly to tell contact from them
_LONGEST_LOOK = 0.010  # s from reading to reading after which a robot may have moved so far that it seems a jump
_LOST_AFTER = 0.3  # s without a foot on the ground after which the robot hangs or lies: IMU alone would drift away


class Estimator:
    """What control believes of the robot.

    Args:
        robot: the robot.
        dynamics: is kept up to date with what is believed.

    Attributes:
        estimate: of the last update; its arrays are the same ones always.
        load: what the feet carry.
        contact: what touches arms and torso.
        watch: says which sensors failed.
        heard: servo periods that were heard of since the last update.
    """

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics) -> None:
        joints, sensors = len(robot.joint_names), robot.config.sensors
        self._dynamics = dynamics
        self._filter = InvariantFilter(
            FilterNoise(
                gyro_bias=sensors.gyro.bias,
                accelerometer_bias=sensors.accelerometer.bias,
                tilt=sensors.orientation.bias + sensors.orientation.noise,
            )
        )
        self.load = FootLoad(robot, dynamics)
        self.contact = ContactObserver(robot, dynamics)
        self._ground = Ground()
        self._sole_heights: Array = dynamics.sole_positions[:, 2]
        self._feels = sensors.foot_force is not None
        self.estimate = Estimate(
            0.0, np.zeros(BASE_COORDINATES + joints), np.zeros(BASE_DOFS + joints), np.zeros(joints), self.load.force
        )
        qpos, qvel = self.estimate.qpos, self.estimate.qvel
        self._quaternion, self._joints, self._speeds = (
            qpos[3:BASE_COORDINATES],
            qpos[BASE_COORDINATES:],
            qvel[BASE_DOFS:],
        )
        self.watch = SensorWatch(robot)
        self._velocity_before: Array = np.zeros(BASE_DOFS + joints)
        self._acceleration: Array = np.zeros(BASE_DOFS + joints)
        self._base_acceleration = self._acceleration[:3]
        belief = self._filter
        self._believe = _believe.bind(
            qpos, qvel, self.estimate.joint_torque, self._velocity_before, self._acceleration,
            belief.position, belief.quaternion, belief.velocity, belief.gyro_bias,
        )  # fmt: skip
        self._sums: Array = np.zeros(len(Reading(joints).rates))  # of what was heard since the last update
        self._means: Array = np.zeros_like(self._sums)
        self._hear = _hear.bind(self._sums)
        self._average = _average.bind(self._sums, self._means)
        self._imu, self._torque = self._means[:6], self._means[-joints:]
        self._specific_force, self._turning = self._imu[:3], self._imu[3:]
        self._force: Array = np.zeros(3)  # what the accelerometer said last when it was not doubted [m/s^2]
        self.heard = self._since = self._turn = 0
        self._missed = 0  # servo periods since the last update of which nothing was heard that is believed
        self._waited = 0  # servo cycles since the last new reading
        self._gap = 0  # the longest of these and of the periods that a reading tells of, since the last update
        self._rate: Array = np.zeros(3)  # of the base, where the gyroscope does not say it
        self._said: Array | None = None  # the orientation at the last update without a gyroscope, shape (4,)
        self._upright = _STEADY  # s
        self._still = self._lost = 0.0
        self._stands_for = [_STEADY, _STEADY]  # s, of each foot
        self._slides_for: Array = np.zeros(2)  # s, likewise
        self._slips = _slips.bind(
            dynamics.sole_positions, belief.feet, self._slides_for, self.load.force, _ROLLS_BELOW * robot.mass * GRAVITY
        )
        self._least_upright = math.cos(robot.config.fall.tilt)

    def reset(self, reading: Reading, place: tuple[float, float, float]) -> None:
        """Begin with a robot that stands at rest, both feet on the ground.

        Args:
            reading: what its sensors say.
            place: where it stands: x, y [m] of the middle between its soles, and their heading [rad].
        """
        estimate, dynamics = self.estimate, self._dynamics
        x, y, heading = place
        estimate.qvel[:] = 0.0
        estimate.qpos[:3] = 0.0
        estimate.qpos[3:BASE_COORDINATES] = reading.orientation / np.linalg.norm(reading.orientation)
        estimate.qpos[BASE_COORDINATES:] = reading.joint_position
        estimate.joint_torque[:] = reading.joint_torque
        dynamics.update(estimate)
        turn = heading - middle(dynamics.soles["left"], dynamics.soles["right"]).item(2)
        estimate.qpos[3:BASE_COORDINATES] = _turned(estimate.qpos[3:BASE_COORDINATES], turn)
        dynamics.update(estimate)
        estimate.qpos[:3] = (x, y, 0.0) - dynamics.sole_positions.mean(axis=0)
        dynamics.update(estimate)
        self.load.reset()
        self.contact.reset()
        self._ground.reset(self._sole_heights)
        self._filter.reset(estimate.qpos[3:BASE_COORDINATES], estimate.qpos[:3])
        self.watch.reset(reading)
        self._force[:] = reading.accelerometer
        self._clear()
        self._velocity_before[:] = 0.0
        self._rate[:] = 0.0
        self._said = None
        self._upright = _STEADY  # s
        self._still = self._lost = 0.0
        self._stands_for = [_STEADY, _STEADY]
        self._slides_for[:] = 0.0
        self._since = self._turn = 0
        self._missed = self._waited = self._gap = 0
        self._correct()
        self._dated(reading.time)

    def take(self, reading: Reading) -> None:
        """Hear what the sensors say, once a servo cycle; a new reading stands for all the time that it tells of."""
        passed = reading.passed
        if passed == 1 and not self._waited:
            self._hear(reading.rates)
            self.heard += 1
        elif passed:
            self._gap = max(self._gap, self._waited + 1, passed)
            told = 1 if self._missed and not self.heard else passed  # the rest counts as missed already
            self._sums += told * reading.rates
            self.heard += told
            self._waited = 0
        else:
            self._waited += 1
            self._dated(reading.time)

    def miss(self, reading: Reading) -> None:
        """Hear nothing in a servo cycle, for the reading is too old: what was believed last is all there is."""
        self._missed += self.heard + self._waited + 1
        self._waited = 0
        self._clear()
        self._dated(reading.time)

    def update(self, reading: Reading, setpoint: Array) -> Estimate:
        """Return what is believed now, with everything that was heard since the last time.

        Args:
            reading: the last one that was heard.
            setpoint: position, velocity and torque of the joints as the servo has them, which stand in for sensors
                that failed, shape (3, nj).
        """
        estimate, dynamics, belief, watch = self.estimate, self._dynamics, self._filter, self.watch
        heard, missed = self.heard, self._missed
        time = (heard + missed) * SERVO_PERIOD
        finite = self._average(heard)
        self._watch(reading, time)
        if watch.doubted:
            finite = math.isfinite(sum(self._imu.tolist()))
        doubtful = bool(watch.failed) or not finite
        if doubtful:
            self._without_imu(reading, self._imu, time)
        else:
            self._said = None
        belief.predict(self._turning, self._specific_force, time)
        if missed:
            self._retake_tilt(reading)
        self._believe(self._turning if doubtful else reading.gyro, reading.values, time)
        if watch.any_bad:
            self._stand_in(setpoint, time)
        dynamics.update(estimate)
        if missed:
            self._retake_velocity(reading)
        else:
            self._note_forces(reading, doubtful, time)
        if "accelerometer" in watch.failed:
            self._move_by_leg(self._loaded, _LEGS_SHARE, _LEGS_MOST)
        self._since += heard + missed
        self._missed = self._gap = self.heard = 0
        self._note_contact(time)
        self._ground.land(self._sole_heights, self.load.standing)
        if self._lost > _LOST_AFTER:
            self._rest(reading)
        else:
            self._filter_by_turns()
        if sinks := self._ground.sink(time):
            belief.sink(sinks)
        return self._dated(reading.time)

    def _note_forces(self, reading: Reading, doubtful: bool, time: float) -> None:
        """Note what touches the ground and the robot, by what accelerated it for a time [s]."""
        acceleration, felt = self._acceleration, self._filter.acceleration
        if self._feels and not self.watch.bad_feet:
            self.load.sensed(reading.foot_force)
        else:
            self.load.explain(self.estimate.qvel, acceleration, self._torque, felt.item(2))
        if doubtful or self.watch.any_bad or self._gap > _LONGEST_GAP:
            self.contact.forget()
        else:
            self._base_acceleration[:] = felt
            self.contact.update(acceleration, self._torque, time)

    def _retake_velocity(self, reading: Reading) -> None:
        """Take the velocity from the leg that carries the robot after readings were missed.

        Torques do not say which one that is, for what accelerated the robot meanwhile is not known. Its sole is the
        lower one.
        """
        if self._feels and not self.watch.bad_feet:
            self.load.sensed(reading.foot_force)
        self.contact.forget()
        self._move_by_leg(int(np.argmin(self._sole_heights)), 1.0, math.inf)
        self.estimate.qvel[:3] = self._filter.velocity
        self._dynamics.update(self.estimate)

    def _watch(self, reading: Reading, time: float) -> None:
        """Look for sensors that fail; believe an accelerometer that is doubted no more than a part of what it says.

        A foot that lands hard makes it jump as well, and then it is right. A gyroscope that is doubted says nothing.
        """
        if self._missed or time > _LONGEST_LOOK:
            self.watch.resume(reading, self._means)  # nothing jumped: much may have happened meanwhile
        else:
            self.watch.look(reading, self._means, time, self._upright >= _STEADY)
        force, before, doubted = self._specific_force, self._force, self.watch.doubted
        if "gyro" in doubted:
            self._turning[:] = math.nan
        if "accelerometer" in doubted:
            force[:] = clamp(force, before - _DOUBTED_MOST, before + _DOUBTED_MOST)
        else:
            before[:] = force

    def _retake_tilt(self, reading: Reading) -> None:
        """Take the tilt from the IMU's own filter, which went on while readings were missed."""
        if "orientation" not in self.watch.failed and math.isfinite(sum(reading.orientation.tolist())):
            self._filter.turn_to(self._headed(reading.orientation))

    def _headed(self, said: Array) -> Array:
        """Return an orientation that the IMU says, with the heading that is believed in place of its own."""
        said = said / np.linalg.norm(said)
        return _turned(said, yaw_of(self._filter.quaternion) - yaw_of(said))

    @property
    def _loaded(self) -> int:
        """Which foot carries more: 0 the left one, 1 the right one."""
        return int(np.argmax(self.load.force))

    def _move_by_leg(self, leg: int, share: float, most: float) -> None:
        """Take the velocity with which a sole on the ground seems to move for an error of the base's velocity.

        Args:
            leg: whose sole that is: 0 the left one's, 1 the right one's.
            share: of it that is believed.
            most: of it that is believed at most [m/s].
        """
        if any(self.load.standing) and "gyro" not in self.watch.failed:  # which says how the legs are turned
            moves = self._dynamics.sole_velocity(leg)
            self._filter.slow(moves * (share * min(1.0, most / max(math.hypot(*moves.tolist()), 1e-9))))

    def _stand_in(self, setpoint: Array, time: float) -> None:
        """Believe of joints whose sensors failed that they are where the servo has them."""
        bad = self.watch.bad_joints
        self._joints[bad], self._speeds[bad], self.estimate.joint_torque[bad] = setpoint[:, bad]
        self._torque[bad] = setpoint[2, bad]
        np.subtract(self.estimate.qvel, self._velocity_before, out=self._acceleration)
        self._acceleration /= time

    def _dated(self, time: float) -> Estimate:
        """Return the estimate as one of a time [s]: ``replace`` takes as long as a small matrix product."""
        before = self.estimate
        self.estimate = Estimate(time, before.qpos, before.qvel, before.joint_torque, before.foot_force)
        return self.estimate

    @property
    def covariance(self) -> Array:
        """Of (turn, velocity, position) of the base, world frame, shape (9, 9) [rad, m/s, m]."""
        return self._filter.covariance

    def _filter_by_turns(self) -> None:
        """Let doubt grow, correct, rest: each of the first two takes as long as all the rest of an update."""
        self._turn = (self._turn + 1) % _TURNS
        if self._turn == 1:
            self._filter.doubt(self._since * SERVO_PERIOD, self._slip())
            self._since = 0
        elif self._turn == 2:
            self._correct()

    def _correct(self) -> None:
        dynamics = self._dynamics
        headings = dynamics.sole_headings.tolist()
        self._filter.correct(dynamics.sole_positions, headings, self.load.standing, self._ground.heights)

    def _note_contact(self, time: float) -> None:
        standing, (_, x, y, _) = self.load.standing, self._quaternion.tolist()
        upright = 1 - 2 * (x * x + y * y)  # cosine of the base's tilt
        if upright < self._least_upright:
            standing[:] = False, False
        (left, right), (before_left, before_right) = standing, self._stands_for
        self._upright = self._upright + time if upright > _SURELY_UPRIGHT else 0.0
        self._still = self._still + time if left and right else 0.0
        self._lost = 0.0 if left or right else self._lost + time
        self._stands_for = [before_left + time if left else 0.0, before_right + time if right else 0.0]

    def _rest(self, reading: Reading) -> None:
        """Take the tilt from the IMU's own filter and the height from the legs: no foot says more."""
        position = self._filter.position
        height = position[2] - self._sole_heights.min()
        if "orientation" in self.watch.failed:
            return
        self._filter.rest(self._headed(reading.orientation), np.array([position[0], position[1], height]))
        self._turn = self._since = 0

    def _without_imu(self, reading: Reading, imu: Array, time: float) -> None:
        """Put something else in the place of what the IMU does not say any more."""
        failed, belief = self.watch.failed, self._filter
        unbelieved = failed | self.watch.doubted
        told = "orientation" not in unbelieved and math.isfinite(sum(reading.orientation.tolist()))
        if "accelerometer" in failed or not math.isfinite(imu[:3].sum()):
            imu[:3] = belief.still
            belief.lose_accelerometer()
        if "gyro" in failed or not math.isfinite(imu[3:].sum()):
            if told:
                self._rate += _SAID_SHARE * (self._turn_said(reading) / time - self._rate)
            elif any(self.load.standing):  # a sole is flat on the ground
                tilt = self._dynamics.sole_tilt(self._loaded)
                turn = belief.level(tilt * _LEVEL_SHARE)
                self._rate += turn * (_RATE_SHARE / time)
            imu[3:] = self._rate + belief.gyro_bias
        else:
            self._rate[:], self._said = imu[3:] - belief.gyro_bias, None

    def _turn_said(self, reading: Reading) -> Array:
        """Return how the base has turned by what the orientation says, base frame, shape (3,) [rad].

        At first it takes the tilt from there, for what a gyroscope said before it was known to fail was believed.
        """
        said, before = reading.orientation / np.linalg.norm(reading.orientation), self._said
        self._said = said
        if before is None:
            self._filter.turn_to(self._headed(said))
            return np.zeros(3)
        turn = np.empty(3)
        mujoco.mju_subQuat(turn, said, before)
        return turn

    def _slip(self) -> tuple[float, float]:
        """Return how much each sole may have moved since doubt grew last, as times the slip of a loaded one."""
        if self._still > _STILL_AFTER:
            return _STILL, _STILL
        surely = not (self.watch.suspicious or self.watch.failed)  # else it may be the IMU that is wrong
        return self._slips(self._since * SERVO_PERIOD, surely, *self.load.standing, *self._stands_for)

    def _clear(self) -> None:
        self._sums[:] = 0.0
        self.heard = 0


@bindable("void(f8[::1])", "f8[::1]")
def _hear(rates: Array, sums: Array) -> None:
    """Add what a reading says to sums."""
    sums += rates


@bindable("b1(i8)", "f8[::1], f8[::1]")
def _average(count: int, sums: Array, means: Array) -> bool:
    """Write the means of what was summed up so often, begin a new sum, and return whether those of the IMU are finite.

    Args:
        count: of readings.
        sums, means: of their rates, the IMU's first.
    """
    total = 0.0
    for place in range(len(sums)):
        means[place] = sums[place] / count
        sums[place] = 0.0
        if place < 6:
            total += means[place]
    return math.isfinite(total)


@bindable(
    "void(f8[::1], f8[::1], f8)", "f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1]"
)
def _believe(
    rate: Array,
    values: Array,
    time: float,
    qpos: Array,
    qvel: Array,
    joint_torque: Array,
    before: Array,
    acceleration: Array,
    position: Array,
    quaternion: Array,
    velocity: Array,
    gyro_bias: Array,
) -> None:
    """Write what is believed of base and joints, what was believed of their velocities, and how these change.

    Args:
        rate: what a gyroscope says, shape (3,) [rad/s].
        values: of the reading.
        time: since the last estimate [s].
        qpos, qvel, joint_torque: of the estimate.
        before: qvel as it was.
        acceleration: how much qvel has changed in this time, per second.
        position, quaternion, velocity, gyro_bias: of the filter.
    """
    before[:] = qvel
    qpos[:3], qpos[3:7], qvel[:3] = position, quaternion, velocity
    for axis in range(3):
        qvel[3 + axis] = rate[axis] - gyro_bias[axis]
    joints = len(joint_torque)
    qpos[7:], qvel[6:] = values[6 : 6 + joints], values[12 + joints : 12 + 2 * joints]
    joint_torque[:] = values[12 + 2 * joints :]
    for dof in range(len(qvel)):
        acceleration[dof] = (qvel[dof] - before[dof]) / time


@bindable("UniTuple(f8, 2)(f8, b1, b1, b1, f8, f8)", "f8[:, ::1], f8[:, ::1], f8[::1], f8[::1], f8")
def _slips(
    time: float,
    surely: bool,
    left_stands: bool,
    right_stands: bool,
    left_stands_for: float,
    right_stands_for: float,
    soles: Array,
    before: Array,
    slides_for: Array,
    force: Array,
    rolls_below: float,
) -> tuple[float, float]:
    """Return how much each sole may have moved; one that slides on the ground, as one in the air.

    A sole slides if the base does not move as it would if that sole stayed.

    Args:
        time: since they were asked for last [s].
        surely: whether it is not the IMU that may be wrong.
        left_stands, right_stands, left_stands_for, right_stands_for: whether they stand, and for how long [s].
        soles, before: where they seem to be, and were corrected last, world frame, shape (2, 3) [m].
        slides_for: for how long they have slid is brought up to date, shape (2,) [s].
        force: on them, shape (2,) [N].
        rolls_below: force of one that rolls [N].
    """
    slips = (0.0, 0.0)
    for foot in range(2):
        stands, stands_for = (right_stands, right_stands_for) if foot else (left_stands, left_stands_for)
        way = math.hypot(soles[foot, 0] - before[foot, 0], soles[foot, 1] - before[foot, 1])
        moves = surely and stands and way > _SLIDES * time
        slides_for[foot] = slides_for[foot] + time if moves else 0.0
        free = stands_for < time + _LANDS or 0.0 < slides_for[foot] < _SLIDES_FOR
        slips = slips[1], FREE if free else _ROLLING if force[foot] < rolls_below else 1.0
    return slips


def _turned(quaternion: Array, yaw: float) -> Array:
    """Return a quaternion, shape (4,), turned about the vertical [rad]."""
    w, x, y, z = quaternion.tolist()
    cos, sin = math.cos(yaw / 2), math.sin(yaw / 2)
    return np.array([cos * w - sin * z, cos * x - sin * y, cos * y + sin * x, cos * z + sin * w])
