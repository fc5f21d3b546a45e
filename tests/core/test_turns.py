"""Rotations in machine code, against mink's and those of core/geometry."""

from __future__ import annotations

import math

import mink
import numpy as np
import pytest

from humanoid_bt.core import geometry, turns

TURNS = [np.random.default_rng(seed).normal(scale=scale, size=3) for seed in range(5) for scale in (1e-9, 0.1, 0.8)]


@pytest.mark.parametrize("turn", TURNS)
def test_a_quaternion_has_its_rotation_vector(turn: np.ndarray) -> None:
    quaternion = turns.of_vector(*turn)
    np.testing.assert_allclose(quaternion, geometry.exp(np.concatenate([np.zeros(3), turn]))[3:], atol=1e-12)
    np.testing.assert_allclose(turns.to_vector(quaternion), turn, atol=1e-9)


@pytest.mark.parametrize("turn", [*(turn * 2 for turn in TURNS), *(np.eye(3) * 3.1), *(np.eye(3) * -3.1)])
def test_a_matrix_has_its_quaternion(turn: np.ndarray) -> None:
    """Each part of it is the largest once."""
    quaternion = np.array(turns.of_matrix(mink.SO3.exp(turn).as_matrix().reshape(9)))
    same = mink.SO3(quaternion).as_matrix()
    np.testing.assert_allclose(same, mink.SO3.exp(turn).as_matrix(), atol=1e-9)


def test_a_turn_between_two_goes_the_short_way() -> None:
    start, end = turns.of_vector(0.1, 0.2, 0.3), turns.of_vector(0.3, -0.5, 0.1)
    other_sign = tuple(-part for part in end)
    turn = turns.between(start, end)
    np.testing.assert_allclose(turns.between(start, other_sign), turn, atol=1e-12)
    np.testing.assert_allclose(turn, geometry.turn_between(np.array(start), np.array(end)), atol=1e-12)
    np.testing.assert_allclose(turns.product(turns.of_vector(*turn), start), end, atol=1e-12)


def test_vectors_are_turned_as_by_the_matrix() -> None:
    quaternion, vector = turns.of_vector(0.4, -0.7, 1.1), (0.3, 0.5, -0.2)
    expected = geometry.rotation_matrix(np.array(quaternion)) @ vector
    np.testing.assert_allclose(turns.turned(quaternion, vector), expected, atol=1e-12)


def test_a_view_is_that_of_geometry() -> None:
    np.testing.assert_allclose(turns.view_along(0.7, 0.3), geometry.view_along(0.7, 0.3), atol=1e-12)


def test_what_leans_is_turned_about_its_own_axis() -> None:
    turned, straight = (geometry.rotation_matrix(np.array(turns.leaning(0.4, 0.3, yaw))) for yaw in (0.5, 0.0))
    np.testing.assert_allclose(turned[:, 2], straight[:, 2], atol=1e-12)
    assert np.arccos(turned[:, 0] @ straight[:, 0]) == pytest.approx(0.5)


def test_what_is_tilted_is_turned_about_the_worlds_axes() -> None:
    upright = turns.of_vector(0.0, 0.0, 0.8)
    tilted = geometry.rotation_matrix(np.array(turns.tilted(upright, 0.02, -0.01)))
    np.testing.assert_allclose(tilted[:, 2], [-0.01, -0.02, 1.0], atol=1e-3)
    assert math.atan2(tilted[1, 0], tilted[0, 0]) == pytest.approx(0.8, abs=1e-3)
