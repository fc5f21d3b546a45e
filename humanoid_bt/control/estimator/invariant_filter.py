"""Where the base is and how it moves, from IMU and standing feet: a contact-aided invariant extended Kalman filter.

After R. Hartley, M. Ghaffari, R. M. Eustice, J. W. Grizzle, "Contact-aided invariant extended Kalman filtering for
robot state estimation", IJRR 39(4), 2020: the error is right-invariant, so that its dynamics hardly depend on the
estimate. Beyond the paper: the heading of each standing sole is a state, too, which makes the gyroscope's bias
about the vertical observable; and heights are measured from the ground that the robot stands on: they do not drift.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.control.estimator.small_matrices import measured, times, turn
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import Array

FREE = 1e3
"""Times the slip of a loaded sole: a foot in the air may be anywhere."""

_NO_ACCELEROMETER = 2.0  # m/s^2/sqrt(Hz), of what a walking robot does
_TURN, _VELOCITY, _POSITION = slice(0, 3), slice(3, 6), slice(6, 9)  # of the error
_FEET, _GYRO, _ACCELEROMETER, _SOLES = (slice(9, 12), slice(12, 15)), slice(15, 18), slice(18, 21), slice(21, 23)
_SIZE = 23
_TURNED = 15  # of these, what a turn of the world turns: orientation, velocity, position, feet
_ROWS = 10  # of a measurement: position of each foot, heading of each sole, height of each foot
_UNKNOWN = 1e2  # m^2, the variance of the height of the ground under a foot in the air
_FALL = np.array([[0.0, GRAVITY, 0.0], [-GRAVITY, 0.0, 0.0], [0.0, 0.0, 0.0]])  # the matrix of gravity x


@dataclass(frozen=True)
class FilterNoise:
    """What the filter believes of its inputs: densities of what is random, standard deviations of what is unknown.

    Attributes:
        gyro, accelerometer: [rad/s/sqrt(Hz)], [m/s^2/sqrt(Hz)].
        gyro_bias, accelerometer_bias: at the beginning [rad/s], [m/s^2].
        gyro_drift, accelerometer_drift: of the biases [rad/s/sqrt(s)], [m/s^2/sqrt(s)].
        slip, twist: of a loaded sole of a robot that steps: it rolls a little [m/sqrt(s)], [rad/sqrt(s)].
        foot, heading: of what the joints say of a sole [m], [rad].
        ground: of the height of the ground under a foot [m].
        tilt: at the beginning [rad].
    """

    gyro: float = 5e-4
    accelerometer: float = 0.1
    gyro_bias: float = 1e-3
    accelerometer_bias: float = 0.03
    gyro_drift: float = 1e-6
    accelerometer_drift: float = 1e-4
    slip: float = 0.02
    twist: float = 0.1
    foot: float = 3e-3
    heading: float = 1e-3
    ground: float = 0.03
    tilt: float = 0.01


class InvariantFilter:
    """Estimates orientation, velocity and position of the base in the world that it began in.

    Args:
        noise: what it believes of its inputs.

    Attributes:
        quaternion: of the base, shape (4,).
        velocity, position: of the base, world frame, shape (3,) [m/s], [m].
        feet: of the soles, as they were corrected last, world frame, shape (2, 3) [m].
        gyro_bias, accelerometer_bias: base frame, shape (3,) [rad/s], [m/s^2].
        acceleration: of the base by the accelerometer in the last prediction, world frame, shape (3,) [m/s^2].
    """

    def __init__(self, noise: FilterNoise | None = None) -> None:
        self._noise = self._usual = noise = noise or FilterNoise()
        self.quaternion: Array = np.array([1.0, 0.0, 0.0, 0.0])
        self._turn9: Array = np.eye(3).reshape(9)
        self._turn = self._turn9.reshape(3, 3)
        self._state: Array = np.zeros(_SIZE - 3)  # all but the orientation, in the error's order
        points = self._state[:12].reshape(4, 3)
        self.velocity, self.position, self.feet = points[0], points[1], points[2:]
        self._heights = self._state[5:12:3]  # of base and feet
        self.gyro_bias, self.accelerometer_bias = self._state[12:15], self._state[15:18]
        self.acceleration: Array = np.zeros(3)
        self._covariance: Array = np.zeros((_SIZE, _SIZE))
        self._scratch = np.zeros((_SIZE, _SIZE))
        self._lever = np.zeros((_TURNED, 3))  # what a small turn of the world does to what it turns
        self._lever[:3] = np.eye(3)
        self._transition = np.eye(_SIZE)
        self._growth: Array = np.zeros(_SIZE)
        self._time = 0.0  # that transition and growth are for [s]
        self._measures = np.zeros((_ROWS, _SIZE))
        for foot in range(2):
            rows = slice(3 * foot, 3 * foot + 3)
            self._measures[rows, _POSITION], self._measures[rows, _FEET[foot]] = -np.eye(3), np.eye(3)
            self._measures[6 + foot, 2], self._measures[6 + foot, _SOLES.start + foot] = -1.0, 1.0
            self._measures[8 + foot, _FEET[foot].stop - 1] = 1.0
        self._innovation = np.zeros((_ROWS, _SIZE + 1))  # that of the covariance, and last that of the state
        self._spread = np.zeros((_ROWS, _ROWS))
        self._doubt: Array = np.full(_ROWS, noise.foot**2)
        self._doubt[6:8], self._doubt[8:] = noise.heading**2, noise.ground**2
        self._predict = _predict.bind(self._state, self.quaternion, self._turn, self.acceleration)
        self._doubt_more = _doubt.bind(
            self._covariance, self._transition, self._state, self._turn, self._growth, self._lever, self._scratch,
        )  # fmt: skip
        self._correct = _correct.bind(
            self._state, self._covariance, self.quaternion, self._turn, self._measures, self._doubt, self._lever,
            self._innovation, self._spread,
        )  # fmt: skip

    def reset(self, quaternion: Array, position: Array) -> None:
        """Begin with a robot at rest at a known place, whose feet are in the air.

        Args:
            quaternion, position: of the base, shapes (4,) and (3,) [m].
        """
        self._noise = noise = self._usual
        self._time = 0.0
        self._state[:] = 0.0
        variances = self._covariance.diagonal().copy()
        variances[2] = variances[6] = variances[7] = 1e-8
        variances[_GYRO], variances[_ACCELEROMETER] = noise.gyro_bias**2, noise.accelerometer_bias**2
        self._rest(quaternion, position, variances)

    def rest(self, quaternion: Array, position: Array) -> None:
        """Go on from a pose at rest, with feet in the air: what was learnt of the IMU and of the way stays.

        Args:
            quaternion, position: of the base, shapes (4,) and (3,) [m].
        """
        self._rest(quaternion, position, self._covariance.diagonal().copy())

    def _rest(self, quaternion: Array, position: Array, variances: Array) -> None:
        self.quaternion[:], self.position[:], self.velocity[:] = quaternion, position, 0.0
        mujoco.mju_quat2Mat(self._turn9, self.quaternion)
        variances[:2], variances[_VELOCITY], variances[8] = self._noise.tilt**2, 1e-4, 1e-2
        variances[_FEET[0]] = variances[_FEET[1]] = variances[_SOLES] = 1e2
        self._covariance[:] = np.diag(variances)

    @property
    def covariance(self) -> Array:
        """Of (turn, velocity, position) of the base, world frame, shape (9, 9) [rad, m/s, m]."""
        covariance: Array = np.empty((9, 9))
        _symmetric(self._covariance, covariance)
        return covariance

    def lose_accelerometer(self) -> None:
        """From now on velocity comes from the feet, until :meth:`reset`."""
        self._noise, self._time = replace(self._noise, accelerometer=_NO_ACCELEROMETER), 0.0

    @property
    def still(self) -> Array:
        """What the accelerometer would say at rest, base frame, shape (3,) [m/s^2]."""
        return np.asarray(self._turn[2] * GRAVITY + self.accelerometer_bias)

    def level(self, tilt: Array) -> Array:
        """Turn the base back by what something level seems to be tilted; return by how much, base frame, shape (3,).

        Args:
            tilt: rotation vector by which it seems to be turned, world frame, shape (3,) [rad].
        """
        turn = np.asarray(-tilt @ self._turn)
        mujoco.mju_quatIntegrate(self.quaternion, turn, 1.0)
        mujoco.mju_quat2Mat(self._turn9, self.quaternion)
        return turn

    def turn_to(self, quaternion: Array) -> None:
        """Turn the base to an orientation, shape (4,)."""
        self.quaternion[:] = quaternion
        mujoco.mju_quat2Mat(self._turn9, self.quaternion)

    def predict(self, rate: Array, force: Array, time: float) -> None:
        """Go on for a time [s] with what the IMU measured in it, on average.

        Args:
            rate: angular velocity, base frame, shape (3,) [rad/s].
            force: specific force, which is what an accelerometer measures, base frame, shape (3,) [m/s^2].
            time: [s].
        """
        self._predict(rate, force, time)

    def doubt(self, time: float, slip: tuple[float, float]) -> None:
        """Let the covariance grow by what predictions over a time [s] add to it.

        Args:
            time: [s].
            slip: how much more than a loaded sole of a robot that steps each sole may move, :data:`FREE` in the air.
        """
        if time != self._time:
            self._set_time(time)
        noise = self._noise
        self._doubt_more(time, *slip, noise.slip, noise.twist, noise.gyro**2 * time)

    def _set_time(self, time: float) -> None:
        noise, transition, growth = self._noise, self._transition, self._growth
        self._time = time
        transition[_VELOCITY, _TURN], transition[_POSITION, _TURN] = _FALL * time, _FALL * (time**2 / 2)
        transition[_POSITION, _VELOCITY] = np.eye(3) * time
        growth[_VELOCITY] = noise.accelerometer**2 * time
        growth[_GYRO], growth[_ACCELEROMETER] = noise.gyro_drift**2 * time, noise.accelerometer_drift**2 * time

    def slow(self, velocity: Array) -> None:
        """Take a velocity, world frame, shape (3,) [m/s], off the base's."""
        self.velocity -= velocity

    def sink(self, way: float) -> None:
        """Count heights from a ground that is higher by so much [m]."""
        self._heights -= way

    def correct(
        self, feet: Array, headings: Sequence[float], standing: Sequence[bool], ground: Sequence[float] = (0.0, 0.0)
    ) -> None:
        """Correct the estimate by what the joints say of the feet.

        Args:
            feet: positions of the soles with the base where it is predicted, world frame, shape (2, 3) [m].
            headings: of the soles, likewise [rad].
            standing: whether each foot is on the ground.
            ground: how high that is under each [m].
        """
        self._correct(
            feet, headings[0], headings[1], standing[0], standing[1], ground[0], ground[1], self._noise.ground**2
        )


@compiled("void(f8[:, ::1], f8[:, ::1])")
def _symmetric(whole: Array, part: Array) -> None:
    """Write the first part of a covariance, symmetric to the bit: a recording keeps half of it."""
    for i in range(len(part)):
        for j in range(len(part)):
            part[i, j] = (whole[i, j] + whole[j, i]) / 2


@bindable("void(f8[::1], f8[::1], f8)", "f8[::1], f8[::1], f8[:, ::1], f8[::1]")
def _predict(
    rate: Array, force: Array, time: float, state: Array, quaternion: Array, turned: Array, acceleration: Array
) -> None:
    """See :meth:`InvariantFilter.predict`."""
    wx, wy, wz = rate[0] - state[12], rate[1] - state[13], rate[2] - state[14]
    fx, fy, fz = force[0] - state[15], force[1] - state[16], force[2] - state[17]
    half = time / 2  # it turns while it accelerates
    x, y, z = fx + half * (wy * fz - wz * fy), fy + half * (wz * fx - wx * fz), fz + half * (wx * fy - wy * fx)
    for i in range(3):
        gain = turned[i, 0] * x + turned[i, 1] * y + turned[i, 2] * z
        if i == 2:
            gain -= GRAVITY
        gain *= time
        state[3 + i] += (state[i] + gain / 2) * time
        state[i] += gain
    turn(quaternion, turned, wx * time, wy * time, wz * time)
    for i in range(3):
        acceleration[i] = turned[i, 0] * fx + turned[i, 1] * fy + turned[i, 2] * fz
    acceleration[2] -= GRAVITY


@inlined
def _cross(state: Array, lever: Array) -> None:
    """Write what a small turn of the world does to velocity, position and feet: v x, below one another."""
    for point in range(4):
        x, y, z = state[3 * point], state[3 * point + 1], state[3 * point + 2]
        row = 3 + 3 * point
        lever[row, 1], lever[row, 2] = -z, y
        lever[row + 1, 0], lever[row + 1, 2] = z, -x
        lever[row + 2, 0], lever[row + 2, 1] = -y, x


@bindable(
    "void(f8, f8, f8, f8, f8, f8)", "f8[:, ::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[:, ::1]"
)
def _doubt(
    time: float,
    left_slip: float,
    right_slip: float,
    slip: float,
    twist: float,
    turning: float,
    covariance: Array,
    transition: Array,
    state: Array,
    turned: Array,
    growth: Array,
    lever: Array,
    scratch: Array,
) -> None:
    """Let the covariance P grow: F P F^T + Q.

    Args:
        time: [s].
        left_slip, right_slip: how much more than a loaded sole of a robot that steps each sole may move.
        slip, twist: how much that one does [m/sqrt(s)], [rad/sqrt(s)].
        turning: variance of what turns everything [rad^2].
        covariance: P.
        transition: F, but for what depends on where the base is.
        state, turned: where it is.
        growth: the rest of the diagonal of Q; what depends on the soles is written.
        lever, scratch: are written.
    """
    for foot in range(2):
        more = right_slip if foot else left_slip
        for axis in range(3):
            growth[9 + 3 * foot + axis] = (slip * more) ** 2 * time
        growth[21 + foot] = (twist * more) ** 2 * time
    _cross(state, lever)
    for j in range(3):
        a, b, c = -time * turned[0, j], -time * turned[1, j], -time * turned[2, j]
        transition[3, 18 + j], transition[4, 18 + j], transition[5, 18 + j] = a, b, c
        for i in range(_TURNED):
            transition[i, 15 + j] = lever[i, 0] * a + lever[i, 1] * b + lever[i, 2] * c
    times(transition, covariance, scratch)
    for i in range(_SIZE):
        for j in range(_SIZE):
            covariance[i, j] = scratch[j, i]
    times(transition, covariance, scratch)
    covariance[:] = scratch  # symmetric, as F (F P)^T is
    for i in range(_TURNED):
        for j in range(_TURNED):
            covariance[i, j] += turning * (
                lever[i, 0] * lever[j, 0] + lever[i, 1] * lever[j, 1] + lever[i, 2] * lever[j, 2]
            )
    for i in range(_SIZE):
        covariance[i, i] += growth[i]


@bindable(
    "void(f8[:, ::1], f8, f8, b1, b1, f8, f8, f8)",
    "f8[::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[:, ::1], f8[:, ::1]",
)
def _correct(
    feet: Array,
    left_heading: float,
    right_heading: float,
    left_stands: bool,
    right_stands: bool,
    left_ground: float,
    right_ground: float,
    ground_doubt: float,
    state: Array,
    covariance: Array,
    quaternion: Array,
    turned: Array,
    measures: Array,
    doubt: Array,
    lever: Array,
    innovation: Array,
    spread: Array,
) -> None:
    """See :meth:`InvariantFilter.correct`.

    Args:
        feet, left_heading, right_heading: what is measured.
        left_stands, right_stands, left_ground, right_ground: as standing and ground there.
        ground_doubt: variance of the height of the ground under a foot that stands [m^2].
        state, covariance, quaternion, turned: are corrected.
        measures: what is measured of the error, H, shape (rows, size).
        doubt: its variances, the diagonal of R; those of the ground are written.
        lever, innovation, spread: are written.
    """
    _cross(state, lever)
    left, right = (left_heading, left_stands, left_ground), (right_heading, right_stands, right_ground)
    for foot in range(2):
        x, y, z = state[6 + 3 * foot], state[7 + 3 * foot], state[8 + 3 * foot]
        heading, stands, ground = right if foot else left
        doubt[8 + foot] = ground_doubt if stands else _UNKNOWN
        for axis in range(3):
            innovation[3 * foot + axis, _SIZE] = feet[foot, axis] - state[6 + 3 * foot + axis]
        innovation[6 + foot, _SIZE] = (heading - state[18 + foot] + math.pi) % (2 * math.pi) - math.pi
        innovation[8 + foot, _SIZE] = ground - z
        measures[8 + foot, 0], measures[8 + foot, 1] = y, -x
    measured(covariance, measures, doubt, innovation, spread)
    change = np.zeros(_SIZE)
    for k in range(_ROWS):
        share = innovation[k, _SIZE]
        for j in range(_SIZE):
            change[j] += share * innovation[k, j]
    x, y, z = change[0], change[1], change[2]
    for i in range(12):
        state[i] -= lever[3 + i, 0] * x + lever[3 + i, 1] * y + lever[3 + i, 2] * z
    for i in range(_SIZE - 3):
        state[i] += change[3 + i]
    turn(
        quaternion,
        turned,
        x * turned[0, 0] + y * turned[1, 0] + z * turned[2, 0],
        x * turned[0, 1] + y * turned[1, 1] + z * turned[2, 1],
        x * turned[0, 2] + y * turned[1, 2] + z * turned[2, 2],
    )
