"""The height of the ground under the feet, as the estimator takes it when they land."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.estimator.ground import Ground

TIME = 0.005
BOTH, LEFT = (True, True), (True, False)


@pytest.fixture
def ground() -> Ground:
    ground = Ground()
    ground.reset(np.zeros(2))
    return ground


def land(ground: Ground, height: float) -> float:
    """Lift the right foot and put it down at a height [m]; return by how much everything sinks in that update [m]."""
    ground.land(np.zeros(2), LEFT)
    ground.land(np.array([0.0, height]), BOTH)
    return ground.sink(TIME)


def test_level_ground_stays_level(ground: Ground) -> None:
    for height in (0.003, -0.004, 0.0, 0.005):
        assert land(ground, height) == 0
    np.testing.assert_array_equal(ground.heights, [0, 0])


def test_a_foot_that_lands_higher_stands_higher(ground: Ground) -> None:
    assert 0 < land(ground, 0.015) < 1e-4
    assert ground.heights[1] - ground.heights[0] == pytest.approx(0.015)


def test_heights_are_counted_from_where_the_robot_stands_now(ground: Ground) -> None:
    sunk = land(ground, 0.02)
    for _ in range(round(8.0 / TIME)):
        sunk += ground.sink(TIME)
    assert sunk == pytest.approx(0.01, abs=1e-4)
    np.testing.assert_allclose(ground.heights, [-0.01, 0.01], atol=1e-4)
    ground.land(np.array(ground.heights), (False, True))
    sunk += sum(ground.sink(TIME) for _ in range(round(8.0 / TIME)))
    assert sunk == pytest.approx(0.02, abs=1e-4)


def test_a_foot_that_stands_is_not_measured_anew(ground: Ground) -> None:
    land(ground, 0.02)
    before = np.diff(ground.heights)
    ground.land(np.array([0.0, 0.05]), BOTH)
    np.testing.assert_allclose(np.diff(ground.heights), before)


@pytest.mark.parametrize(("right", "told"), [(0.004, 0.0), (0.05, 0.05)])
def test_a_robot_that_begins_on_a_step_stands_on_it(ground: Ground, right: float, told: float) -> None:
    ground.land(np.zeros(2), LEFT)
    ground.reset(np.array([0.0, right]))
    assert ground.heights == [0.0, told]
    ground.land(np.array([0.0, 0.1]), BOTH)  # both feet stood already
    assert ground.heights == [0.0, told]


def test_nothing_sinks_while_no_foot_stands(ground: Ground) -> None:
    land(ground, 0.02)
    ground.land(np.zeros(2), (False, False))
    assert ground.sink(TIME) == 0.0
