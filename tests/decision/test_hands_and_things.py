"""Ways of hands round things, and things as they are seen."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.messages import RESOURCES, Percept, State
from humanoid_bt.decision.giving_way import GivingWay
from humanoid_bt.decision.hand_route import HandRoute
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.surroundings import Surroundings
from humanoid_bt.robot.config import GaitConfig
from tests.decision.watched import watched
from tests.tree.helpers import make_robot, make_state


@pytest.fixture
def robot() -> Robot:
    return make_robot(CycleClock())


def box(name: str, position: tuple[float, ...], size: tuple[float, ...], heading: float = 0.0) -> Percept:
    return Percept(name, 0.0, np.array(position), 0.9, np.array(size), heading)


def hand_at(position: tuple[float, ...]) -> State:
    return dataclasses.replace(make_state(), hands={"left": np.array(position), "right": np.zeros(3)})


def way_of(robot: Robot) -> HandRoute:
    return HandRoute(RobotHandle(robot, "t/reach", RESOURCES))


def test_a_long_table_is_in_the_way_however_far_its_middle_is(robot: Robot) -> None:
    robot.begin_tick(make_state(), {"table": box("table", (0.5, 2.0, 0.0), (0.2, 4.4, 0.1))})
    route = way_of(robot)
    assert route.next("left", [1.0, 0.0, 0.0])[2] > 0
    assert route.blocked == "table"


@pytest.mark.parametrize(("heading", "blocked"), [(math.radians(45), "plank"), (math.radians(-45), "")])
def test_a_box_is_in_the_way_as_it_is_turned(robot: Robot, heading: float, blocked: str) -> None:
    robot.begin_tick(make_state(), {"plank": box("plank", (0.9, 0.4, 0.0), (1.4, 0.02, 0.2), heading)})
    route = way_of(robot)
    route.next("left", [1.0, 0.0, 0.0])
    assert route.blocked == blocked


def test_a_palm_does_not_go_across_below_a_lamp(robot: Robot) -> None:
    seen = {
        "table": box("table", (0.7, 0.0, 0.0), (0.4, 2.0, 0.04)),
        "lamp": box("lamp", (0.45, 0.0, 0.26), (0.1, 2.0, 0.1)),
    }
    robot.begin_tick(hand_at((0.2, 0.2, 0.12)), seen)
    route = way_of(robot)
    place = route.next("left", [0.9, 0.2, 0.05])
    assert route.blocked == "table"
    assert place.tolist() == pytest.approx([0.22, 0.22, 0.15])  # not across, where the lamp is


def test_says_of_two_things_that_they_are_in_the_way(robot: Robot) -> None:
    seen = {name: box(name, (x, 0.0, 0.0), (0.1, 1.0, 0.1)) for name, x in (("box", 0.4), ("shelf", 0.7))}
    robot.begin_tick(make_state(), seen)
    route = way_of(robot)
    route.next("left", [1.0, 0.0, 0.0])
    assert route.why_no_nearer("left", 0.1) == "left hand comes no nearer than 10 cm: box and shelf are in the way"
    assert route.why_no_nearer("left", 0.003).startswith("left hand comes no nearer than 0.3 cm: ")


def test_a_way_that_is_not_shown_again_is_none(robot: Robot) -> None:
    handle = RobotHandle(robot, "walk", ("base",))
    robot.begin_tick(make_state(), {})
    handle.walk_to([1.0, 0.0], 0.0)
    handle.show_route([[0.0, 0.0], [1.0, 0.0]])
    assert len(robot.routes) == 1
    robot.begin_tick(make_state(0.02), {})
    handle.walk_to([1.0, 0.0], 0.0)
    assert robot.routes == []


@pytest.mark.parametrize(("far", "moved"), [(1.0, {"cart"}), (6.0, set())])
def test_what_is_far_is_seen_less_exactly_and_has_not_moved(far: float, moved: set[str]) -> None:
    def seen(now: float) -> list[Percept]:
        return [Percept("cart", now, np.array([far, 0.15 * (now > 1.0), 0.0]), 0.9, np.array([0.4, 0.4, 0.7]))]

    assert watched(seen, 3.0).movers == moved


def test_a_robot_that_stands_deep_in_something_steps_toward_where_it_ends(robot: Robot) -> None:
    robot.begin_tick(make_state(), {"crowd": box("crowd", (1.0, 0.0, 0.0), (4.0, 4.0, 1.0))})
    around = Surroundings(RobotHandle(robot, "walk", ("base",)))
    around.look()
    away = GivingWay(around, GaitConfig(), 0.4).away(np.zeros(2), ())
    assert away is not None
    assert away.tolist() == pytest.approx([-0.05, 0.0])
