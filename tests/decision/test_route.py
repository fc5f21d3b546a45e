"""How long a way is, how far it turns, and where it may end."""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.route import Route
from humanoid_bt.robot.config import GaitConfig
from tests.tree.helpers import make_robot, make_state


@pytest.mark.parametrize(
    ("points", "heading", "length", "turns"),
    [
        ([[0, 0], [2, 0]], 0.0, 2.0, 0.0),
        ([[0, 0], [0, 2]], 0.0, 2.0, math.pi),  # there to the left, and back
        ([[0, 0], [1, 1], [2, 0]], 0.0, 2 * math.sqrt(2), math.pi),
        ([[0, 0], [0, 0.1]], 1.0, 0.1, 1.0),  # it steps aside where that is near
    ],
)
def test_a_way_is_as_long_as_its_parts_and_turns_with_them(
    points: list[list[float]], heading: float, length: float, turns: float
) -> None:
    config = SimpleNamespace(gait=GaitConfig(), walking_radius=0.3, sole=SimpleNamespace(half_length=0.1))
    robot = SimpleNamespace(config=config, state=SimpleNamespace(stance=np.zeros(3)))
    route = Route(robot)  # type: ignore[arg-type]  # all that it asks a robot for to measure a way
    route._measure(np.array(points, dtype=float), heading)
    assert route.to_go == pytest.approx(length)
    assert route.turns_to_go == pytest.approx(turns)


@pytest.mark.parametrize(
    ("place", "up_to", "past"),
    [
        ((2.0, 0.0), False, False),  # in it
        ((1.75, 0.0), False, False),  # its toes would be
        ((1.65, 0.0), True, False),  # facing its long side
        ((2.0, -1.2), True, False),  # facing its end
        ((1.6, 0.8), False, False),  # facing its middle from there, a shoulder would be in it
        ((1.4, 0.0), True, True),
    ],
)
def test_what_it_walks_up_to_leaves_room_for_a_robot_that_faces_it(
    place: tuple[float, float], up_to: bool, past: bool
) -> None:
    robot = make_robot(CycleClock())
    route = Route(RobotHandle(robot, "walk", ("base",)))
    bench = Percept("bench", 0.0, np.array([2.0, 0.0, -0.4]), 0.9, np.array([0.3, 2.0, 0.7]))
    robot.begin_tick(make_state(), {"bench": bench})
    assert route.free([place], ignore=["bench"]) == [up_to]
    assert route.free([place]) == [past]
    assert route.nearest([place], ignore=["bench"]) == (0 if up_to else None)
    assert route.follow(place, heading=0.0, ignore=["bench"]) == up_to


@pytest.mark.parametrize(
    ("places", "said"),
    [
        ([(math.nan, 0.0)], "places must be within 2000 m of the origin, not [[nan, 0.0]]"),
        ([(0.0, -3000.0)], "places must be within 2000 m of the origin, not [[0.0, -3000.0]]"),
        ([(1.0, 0.0, 0.0)], "places must have shape (n, 2), not (1, 3)"),
        ("home", "places must be numbers, shape (n, 2), not 'home'"),
    ],
)
def test_a_place_that_is_none_is_refused(places: Any, said: str) -> None:
    robot = make_robot(CycleClock())
    robot.begin_tick(make_state(), {})
    route = Route(RobotHandle(robot, "walk", ("base",)))
    for ask in (route.free, route.nearest):
        with pytest.raises(ValueError, match=re.escape(said)):
            ask(places)


def test_of_no_places_none_is_free_or_nearest_whatever_was_seen() -> None:
    robot = make_robot(CycleClock())
    route = Route(RobotHandle(robot, "walk", ("base",)))
    for percepts in ({}, {"box": Percept("box", 0.0, np.array([2.0, 0.0, -0.4]), 0.9, np.full(3, 0.5))}):
        robot.begin_tick(make_state(), percepts)
        assert route.free([]) == []
        assert route.nearest([], []) is None
