"""Rotations and rigid motions, against mink's."""

import math

import mink
import numpy as np
import pytest

from humanoid_bt.core.geometry import (
    exp,
    log,
    planar_pose,
    pose_inverse,
    pose_product,
    rotation_matrix,
    view_along,
)

TWISTS = [np.random.default_rng(seed).normal(scale=scale, size=6) for seed in range(5) for scale in (1e-9, 0.1, 0.8)]


def se3(pose: np.ndarray) -> mink.SE3:
    return mink.SE3(np.concatenate([pose[3:], pose[:3]]))


@pytest.mark.parametrize("twist", TWISTS)
def test_the_exponential_is_minks(twist: np.ndarray) -> None:
    np.testing.assert_allclose(se3(exp(twist)).as_matrix(), mink.SE3.exp(twist).as_matrix(), atol=1e-12)


@pytest.mark.parametrize("twist", TWISTS)
def test_the_logarithm_undoes_the_exponential(twist: np.ndarray) -> None:
    np.testing.assert_allclose(log(exp(twist)), twist, atol=1e-9)


def test_the_logarithm_turns_the_short_way() -> None:
    pose = exp(np.array([0.1, 0.2, 0.3, 0.0, 0.0, 0.5]))
    pose[3:] *= -1  # the same rotation
    np.testing.assert_allclose(log(pose)[3:], [0, 0, 0.5], atol=1e-12)


def test_products_and_inverses_are_minks() -> None:
    first, second = exp(TWISTS[2]), exp(TWISTS[5])
    np.testing.assert_allclose(
        se3(pose_product(first, second)).as_matrix(), (se3(first) @ se3(second)).as_matrix(), atol=1e-12
    )
    np.testing.assert_allclose(se3(pose_product(first, pose_inverse(first))).as_matrix(), np.eye(4), atol=1e-12)


def test_a_rotation_matrix_turns_as_its_quaternion() -> None:
    quaternion = exp(TWISTS[8])[3:]
    np.testing.assert_allclose(rotation_matrix(quaternion), mink.SO3(quaternion).as_matrix(), atol=1e-12)


def test_a_planar_pose_is_upright() -> None:
    matrix = rotation_matrix(planar_pose(1, 2, 3, math.pi / 3)[3:])
    np.testing.assert_allclose(matrix[2], [0, 0, 1], atol=1e-12)
    assert math.atan2(matrix[1, 0], matrix[0, 0]) == pytest.approx(math.pi / 3)


@pytest.mark.parametrize(("yaw", "pitch"), [(0.0, 0.0), (0.7, 0.3), (-2.0, 1.0), (3.0, -0.4)])
def test_a_view_looks_along_its_yaw_and_then_down_by_its_pitch(yaw: float, pitch: float) -> None:
    ahead, left, _ = rotation_matrix(view_along(yaw, pitch)).T
    down = math.sin(pitch)
    np.testing.assert_allclose(
        ahead, [math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), -down], atol=1e-12
    )
    assert left[2] == pytest.approx(0, abs=1e-12)
