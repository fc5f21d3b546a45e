from __future__ import annotations

import math

import numpy as np
import pytest

from humanoid_bt.control.body.planar import ahead, middle, rotate, seen_from, wrap


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [
        (0, 0),
        (3, 3),
        (-3, -3),
        (math.pi, -math.pi),
        (7 * math.pi, -math.pi),
        (6.4, 6.4 - 2 * math.pi),
        (-4, 2 * math.pi - 4),
    ],
)
def test_wrap_keeps_the_direction(angle: float, wrapped: float) -> None:
    assert wrap(angle) == pytest.approx(wrapped)


def test_rotate_turns_left() -> None:
    np.testing.assert_allclose(rotate(np.array([1.0, 0.0]), math.pi / 2), [0, 1], atol=1e-12)


def test_ahead_is_in_the_frame_of_the_pose() -> None:
    pose = np.array([1.0, 2.0, math.pi / 2])
    np.testing.assert_allclose(ahead(pose, 0.5, 0.1, 0.2), [0.9, 2.5, math.pi / 2 + 0.2], atol=1e-12)


def test_seen_from_undoes_ahead() -> None:
    numbers = np.random.default_rng(1)
    for _ in range(20):
        pose, offset = numbers.uniform(-3, 3, 3), numbers.uniform(-2, 2, 2)
        np.testing.assert_allclose(seen_from(pose, ahead(pose, *offset)), offset, atol=1e-12)


def test_the_middle_is_between_the_headings_also_across_pi() -> None:
    x, y, yaw = middle(np.array([0.0, 1.0, 3.1]), np.array([2.0, 0.0, -3.1]))
    assert (x, y) == (1.0, 0.5)
    assert wrap(yaw - math.pi) == pytest.approx(0, abs=1e-12)
