"""The filter of the base, on motions whose truth is known."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest

from humanoid_bt.control.estimator.invariant_filter import FREE, FilterNoise, InvariantFilter
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Array

PERIOD = 0.005
FEET = np.array([[0.0, 0.09, 0.0], [0.0, -0.09, 0.0]])
HEIGHT = np.array([0.0, 0.0, 0.7])


@dataclass
class Truth:
    """A base that sways and turns above standing feet: roll and yaw swing, position swings along x."""

    time: float

    @property
    def angles(self) -> tuple[float, float]:
        return 0.1 * math.sin(2 * self.time), 0.2 * math.sin(1.5 * self.time)

    @property
    def quaternion(self) -> Array:
        roll, yaw = self.angles
        cr, sr, cy, sy = math.cos(roll / 2), math.sin(roll / 2), math.cos(yaw / 2), math.sin(yaw / 2)
        return np.array([cy * cr, cy * sr, sy * sr, sy * cr])

    @property
    def position(self) -> Array:
        return HEIGHT + np.array([0.05 * (1 - math.cos(3 * self.time)), 0.0, 0.0])

    @property
    def velocity(self) -> Array:
        return np.array([0.15 * math.sin(3 * self.time), 0.0, 0.0])


def sensed(time: float) -> tuple[Array, Array]:
    """Return rate and specific force in the period that ends at a time, on average."""
    before, after = Truth(time - PERIOD), Truth(time)
    turn = rotation_matrix(before.quaternion).T @ rotation_matrix(after.quaternion)
    rate = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / (2 * PERIOD)
    acceleration = (after.velocity - before.velocity) / PERIOD + [0, 0, 9.81]
    return rate, rotation_matrix(Truth(time - PERIOD / 2).quaternion).T @ acceleration


def run(belief: InvariantFilter, seconds: float, rate_off: Array, force_off: Array, quiet: float = 1.0) -> None:
    for step in range(1, round(seconds / PERIOD) + 1):
        now = Truth(step * PERIOD)
        rate, force = sensed(now.time)
        belief.predict(rate + rate_off, force + force_off, PERIOD)
        if step % 2:
            belief.doubt(2 * PERIOD, (quiet, quiet))
            continue
        seen = (FEET - now.position) @ rotation_matrix(now.quaternion)  # what the legs say, in the base's frame
        feet = seen @ rotation_matrix(belief.quaternion).T + belief.position
        off = rotation_matrix(belief.quaternion) @ rotation_matrix(now.quaternion).T
        heading = math.atan2(off[1, 0], off[0, 0])
        belief.correct(feet, [heading, heading], [True, True])


@pytest.fixture
def belief() -> InvariantFilter:
    belief = InvariantFilter()
    belief.reset(Truth(0.0).quaternion, Truth(0.0).position)
    return belief


def test_it_follows_what_moves(belief: InvariantFilter) -> None:
    run(belief, 4.0, np.zeros(3), np.zeros(3))
    truth = Truth(4.0)
    np.testing.assert_allclose(belief.position, truth.position, atol=1e-3)
    np.testing.assert_allclose(belief.velocity, truth.velocity, atol=5e-3)
    np.testing.assert_allclose(belief.quaternion, truth.quaternion, atol=1e-3)


def test_it_finds_what_the_imu_is_off_and_its_tilt_at_the_beginning(belief: InvariantFilter) -> None:
    tilted = Truth(0.0).quaternion + np.array([0, 0.005, -0.004, 0])
    belief.reset(tilted / np.linalg.norm(tilted), Truth(0.0).position)
    rate_off, force_off = np.array([8e-4, -6e-4, 9e-4]), np.array([0.0, 0.0, 0.02])
    run(belief, 20.0, rate_off, force_off, quiet=0.03)
    assert (np.abs(belief.gyro_bias - rate_off) < 0.6 * np.abs(rate_off)).all()
    np.testing.assert_allclose(belief.quaternion, Truth(20.0).quaternion, atol=2e-3)
    np.testing.assert_allclose(belief.velocity, Truth(20.0).velocity, atol=1e-2)


def test_its_covariance_says_what_feet_can_tell(belief: InvariantFilter) -> None:
    run(belief, 1.0, np.zeros(3), np.zeros(3))
    standing = belief.covariance
    np.testing.assert_allclose(standing, standing.T, atol=1e-15)
    assert np.linalg.eigvalsh(standing).min() > 0
    for _ in range(100):  # half a second in the air
        belief.predict(np.zeros(3), np.array([0.0, 0.0, 9.81]), PERIOD)
        belief.doubt(PERIOD, (FREE, FREE))
    flying = belief.covariance
    assert (np.diag(flying)[3:] > np.diag(standing)[3:]).all()
    assert flying[8, 8] > 10 * standing[8, 8]


def test_its_covariance_is_symmetric_to_the_bit_at_any_moment(belief: InvariantFilter) -> None:
    """Recordings keep half of it, and replays compare it."""
    run(belief, 1.0, np.array([1e-3, 0.0, 0.0]), np.zeros(3))
    for _ in range(3):
        belief.doubt(PERIOD, (1.0, FREE))
        np.testing.assert_array_equal(belief.covariance, belief.covariance.T)


def test_heights_do_not_drift_and_the_way_does(belief: InvariantFilter) -> None:
    run(belief, 20.0, np.zeros(3), np.array([0.0, 0.0, 0.05]))
    assert abs(belief.position[2] - HEIGHT[2]) < 2e-3
    assert belief.covariance[8, 8] < 1e-2 * belief.covariance[6, 6]


def test_a_robot_that_is_put_down_again_keeps_what_it_learnt(belief: InvariantFilter) -> None:
    run(belief, 5.0, np.array([0.0, 0.0, 1e-3]), np.zeros(3), quiet=0.03)
    learnt = belief.gyro_bias.copy()
    belief.rest(np.array([1.0, 0, 0, 0]), np.array([3.0, 2.0, 0.5]))
    np.testing.assert_array_equal(belief.gyro_bias, learnt)
    np.testing.assert_array_equal(belief.velocity, np.zeros(3))
    assert 2e-4 < learnt[2] < 1e-3


def test_without_its_accelerometer_the_feet_say_how_fast_it_is(belief: InvariantFilter) -> None:
    belief.lose_accelerometer()
    for step in range(1, 801):
        now = Truth(step * PERIOD)
        belief.predict(sensed(now.time)[0], belief.still, PERIOD)
        belief.doubt(PERIOD, (1.0, 1.0))
        seen = (FEET - now.position) @ rotation_matrix(now.quaternion)
        feet = seen @ rotation_matrix(belief.quaternion).T + belief.position
        belief.correct(feet, [0.0, 0.0], [True, True])
    np.testing.assert_allclose(belief.velocity, now.velocity, atol=0.05)


def test_noise_is_for_each_filter_its_own() -> None:
    sure, unsure = InvariantFilter(FilterNoise(gyro_bias=1e-5)), InvariantFilter(FilterNoise(gyro_bias=1e-2))
    for belief in (sure, unsure):
        belief.reset(Truth(0.0).quaternion, Truth(0.0).position)
        run(belief, 5.0, np.array([0.0, 0.0, 1e-3]), np.zeros(3), quiet=0.03)
    assert abs(sure.gyro_bias[2]) < 1e-4 < unsure.gyro_bias[2]
