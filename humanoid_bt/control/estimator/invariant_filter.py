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
from scipy.linalg.blas import dtrsm
from scipy.linalg.lapack import dpotrf

from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.messages import Array

FREE = 1e3
"""Times the slip of a loaded sole: a foot in the air may be anywhere."""

_NO_ACCELEROMETER = 2.0  # m/s^2/sqrt(Hz), of what a walking robot does
_TURN, _VELOCITY, _POSITION = slice(0, 3), slice(3, 6), slice(6, 9)  # of the error
_FEET, _GYRO, _ACCELEROMETER, _SOLES = (slice(9, 12), slice(12, 15)), slice(15, 18), slice(18, 21), slice(21, 23)
_SIZE = 23
_TURNED = 15  # of these, what a turn of the world turns: orientation, velocity, position, feet
_ROWS = 10  # of a measurement: position of each foot, heading of each sole, height of each foot
_CROSS = np.zeros((3, 9))  # v @ _CROSS is the matrix of v x, row by row
for _axis, (_plus, _minus) in enumerate(((7, 5), (2, 6), (3, 1))):
    _CROSS[_axis, _plus], _CROSS[_axis, _minus] = 1.0, -1.0
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
    slip: float = 0.03
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
        gyro_bias, accelerometer_bias: base frame, shape (3,) [rad/s], [m/s^2].
    """

    def __init__(self, noise: FilterNoise | None = None) -> None:
        self._noise = self._usual = noise = noise or FilterNoise()
        self.quaternion: Array = np.array([1.0, 0.0, 0.0, 0.0])
        self._turn9: Array = np.eye(3).reshape(9)
        self._turn = self._turn9.reshape(3, 3)
        self._state: Array = np.zeros(_SIZE - 3)  # all but the orientation, in the error's order
        self._points = self._state[:12].reshape(4, 3)
        self.velocity, self.position, self._feet = self._points[0], self._points[1], self._points[2:]
        self.gyro_bias, self.accelerometer_bias = self._state[12:15], self._state[15:18]
        self._covariance: Array = np.zeros((_SIZE, _SIZE))
        self._scratch = np.zeros((_SIZE, _SIZE))
        self._lever = np.zeros((_TURNED, 3))  # what a small turn of the world does to what it turns
        self._lever[:3] = np.eye(3)
        self._cross = self._lever[3:].reshape(4, 9)
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
        self._doubt: Array = np.full(_ROWS, noise.foot**2)
        self._doubt[6:8], self._doubt[8:] = noise.heading**2, noise.ground**2

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
        covariance = self._covariance[:9, :9]
        return np.asarray((covariance + covariance.T) / 2)  # to the bit: a recording keeps half of it

    def lose_accelerometer(self) -> None:
        """From now on velocity comes from the feet, until :meth:`reset`."""
        self._noise, self._time = replace(self._noise, accelerometer=_NO_ACCELEROMETER), 0.0

    @property
    def still(self) -> Array:
        """What the accelerometer would say at rest, base frame, shape (3,) [m/s^2]."""
        return np.asarray(self._turn[2] * GRAVITY + self.accelerometer_bias)

    def acceleration(self, force: Array) -> Array:
        """Return the base's acceleration, world frame, shape (3,) [m/s^2].

        Args:
            force: what the accelerometer says, base frame, shape (3,) [m/s^2].
        """
        acceleration = self._turn @ (force - self.accelerometer_bias)
        acceleration[2] -= GRAVITY
        return np.asarray(acceleration)

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
        rate = rate - self.gyro_bias
        fx, fy, fz = (force - self.accelerometer_bias).tolist()
        wx, wy, wz = rate.tolist()
        half = time / 2  # it turns while it accelerates
        turned = (fx + half * (wy * fz - wz * fy), fy + half * (wz * fx - wx * fz), fz + half * (wx * fy - wy * fx))
        gain = self._turn.dot(turned)
        gain[2] -= GRAVITY
        gain *= time
        self.position += (self.velocity + gain / 2) * time
        self.velocity += gain
        mujoco.mju_quatIntegrate(self.quaternion, rate, time)
        mujoco.mju_quat2Mat(self._turn9, self.quaternion)

    def doubt(self, time: float, slip: tuple[float, float]) -> None:
        """Let the covariance grow by what predictions over a time [s] add to it.

        Args:
            time: [s].
            slip: how much more than a loaded sole of a robot that steps each sole may move, :data:`FREE` in the air.
        """
        if time != self._time:
            self._set_time(time)
        noise, covariance, transition = self._noise, self._covariance, self._transition
        np.dot(self._points, _CROSS, out=self._cross)
        turn = self._turn * -time
        transition[:_TURNED, _GYRO] = self._lever.dot(turn)
        transition[_VELOCITY, _ACCELEROMETER] = turn
        np.dot(transition, covariance, out=self._scratch)
        np.dot(self._scratch, transition.T, out=covariance)
        covariance[:_TURNED, :_TURNED] += self._lever.dot(self._lever.T) * (noise.gyro**2 * time)
        growth = self._growth
        for foot in range(2):
            growth[_FEET[foot]] = (noise.slip * slip[foot]) ** 2 * time
            growth[_SOLES.start + foot] = (noise.twist * slip[foot]) ** 2 * time
        covariance.reshape(-1)[:: _SIZE + 1] += growth

    def _set_time(self, time: float) -> None:
        noise, transition, growth = self._noise, self._transition, self._growth
        self._time = time
        transition[_VELOCITY, _TURN], transition[_POSITION, _TURN] = _FALL * time, _FALL * (time**2 / 2)
        transition[_POSITION, _VELOCITY] = np.eye(3) * time
        growth[_VELOCITY] = noise.accelerometer**2 * time
        growth[_GYRO], growth[_ACCELEROMETER] = noise.gyro_drift**2 * time, noise.accelerometer_drift**2 * time

    def sink(self, way: float) -> None:
        """Count heights from a ground that is higher by so much [m]."""
        self._points[1:, 2] -= way

    def slides(self, feet: Array) -> Array:
        """Return how far the feet seem to have slid since the last correction, in the plane, shape (2,) [m].

        Args:
            feet: as in :meth:`correct`.
        """
        return np.asarray(np.hypot(*(feet - self._feet)[:, :2].T))

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
        state, covariance, measures = self._state, self._covariance, self._measures
        innovation, error = self._innovation[:, :_SIZE], self._innovation[:, _SIZE]
        np.subtract(feet, self._feet, out=error[:6].reshape(2, 3))
        for foot, (x, y, z) in enumerate(self._feet.tolist()):
            turned = headings[foot] - state.item(18 + foot)
            error[6 + foot] = (turned + math.pi) % (2 * math.pi) - math.pi
            error[8 + foot] = ground[foot] - z
            measures[8 + foot, 0], measures[8 + foot, 1] = y, -x
            self._doubt[8 + foot] = self._noise.ground**2 if standing[foot] else 1e2
        np.matmul(measures, covariance, out=innovation)
        spread = innovation.dot(measures.T)
        spread.reshape(-1)[:: _ROWS + 1] += self._doubt
        factor, _ = dpotrf(spread, lower=1)
        halves = dtrsm(1.0, factor, self._innovation, lower=1)
        change = halves.T.dot(halves)
        covariance -= change[:_SIZE, :_SIZE]
        covariance += covariance.T.copy()
        covariance *= 0.5
        turn, rest = change[:3, _SIZE], change[3:_SIZE, _SIZE]
        np.dot(self._points, _CROSS, out=self._cross)
        state[:12] -= self._lever[3:] @ turn
        state += rest
        mujoco.mju_quatIntegrate(self.quaternion, turn @ self._turn, 1.0)
        mujoco.mju_quat2Mat(self._turn9, self.quaternion)
