"""Where tracks are, seen from the robot and in the world."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import Percept, State
from humanoid_bt.perception.track import Track


def about(axis: tuple[float, float, float], angle: float) -> Any:
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) * np.array(axis))])


def track(percept: Percept, place: Any = (1.0, 0, 0), stance: Any = (0.0, 0, 0), turn: Any = None) -> Track:
    state = SimpleNamespace(stance=np.array(stance), base_position=np.zeros(3), base_quaternion=about((0, 0, 1), 0.0))
    return Track(percept, np.array(place), 0.0, cast(State, state), turn=turn)


def seen(**more: Any) -> Percept:
    return Percept("cup", 0.0, np.array([1.0, 0, 0]), 0.5, **more)


@pytest.mark.parametrize(
    ("heading", "place", "bearing"),
    [(3.0, (-1.0, -0.2), math.pi + math.atan(0.2) - 3.0), (-3.0, (-1.0, 0.2), -(math.pi + math.atan(0.2) - 3.0))],
)
def test_the_bearing_of_what_is_ahead_is_small_whichever_way_the_robot_faces(
    heading: float, place: tuple[float, float], bearing: float
) -> None:
    assert track(seen(), (*place, 0.0), (0.0, 0.0, heading)).bearing == pytest.approx(bearing)


def test_the_deviation_is_that_in_the_direction_in_which_it_is_largest() -> None:
    spread = rotation_matrix(about((0, 0, 1), 0.7)) @ np.diag([0.01, 0.04, 0.0001])
    spread = spread @ rotation_matrix(about((0, 0, 1), 0.7)).T
    assert track(seen(covariance=spread)).deviation == pytest.approx(0.2)


def test_covariance_and_orientation_are_turned_into_the_world() -> None:
    base, own = about((0, 0, 1), 0.6), about((1, 0, 0), 0.4)
    found = track(seen(covariance=np.diag([0.04, 0.01, 0.0]), orientation=own), turn=base)
    assert found.covariance_world is not None and found.orientation_world is not None
    ahead, left = np.array([math.cos(0.6), math.sin(0.6), 0]), np.array([-math.sin(0.6), math.cos(0.6), 0])
    assert ahead @ found.covariance_world @ ahead == pytest.approx(0.04)  # uncertain along the base's x, in the world
    assert left @ found.covariance_world @ left == pytest.approx(0.01)
    turned = rotation_matrix(found.orientation_world)
    np.testing.assert_allclose(turned, rotation_matrix(base) @ rotation_matrix(own), atol=1e-12)


def test_what_is_given_in_the_world_stays_as_it_is() -> None:
    spread, own = np.diag([0.04, 0.01, 0.0]), about((1, 0, 0), 0.4)
    found = track(seen(covariance=spread, orientation=own))
    assert found.covariance_world is spread
    assert found.orientation_world is own
