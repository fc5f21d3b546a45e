"""Ways of palms over what is solid."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import RESOURCES, Percept, State
from humanoid_bt.decision.hand_route import HandRoute
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from tests.tree.helpers import make_state


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


def test_what_was_in_the_way_is_not_any_more_once_it_goes_elsewhere(robot: Robot) -> None:
    robot.begin_tick(make_state(), {"table": box("table", (0.5, 0.0, 0.0), (0.2, 1.0, 0.1))})
    route = way_of(robot)
    route.next("left", [1.0, 0.0, 0.0])
    assert route.blocked == "table"
    route.next("left", [-1.0, 0.0, 0.0])
    assert route.blocked == ""


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


def test_a_hand_that_the_robot_lacks_has_no_way(robot: Robot) -> None:
    robot.begin_tick(dataclasses.replace(make_state(), hands={"left": np.zeros(3)}), {})
    route = way_of(robot)
    with pytest.raises(HumanoidBtError, match="the robot has no right hand"):
        route.next("right", (0, 0, 1))
    with pytest.raises(ValueError, match="a side is 'left' or 'right', not 'up'"):
        route.next("up", (0, 0, 1))  # type: ignore[arg-type]  # what a user may write


@pytest.mark.parametrize(("height", "blocked"), [(0.0, "shelf"), (0.25, ""), (-0.25, "")])
def test_a_palm_goes_straight_below_and_above_what_is_far_enough_from_its_way(
    robot: Robot, height: float, blocked: str
) -> None:
    shelf = box("shelf", (0.5, 0.0, height), (0.2, 1.0, 0.1))
    robot.begin_tick(make_state(), {"shelf": shelf})
    route, goal = way_of(robot), [1.0, 0.0, 0.0]
    assert np.array_equal(route.next("left", goal), goal) == (not blocked)
    assert route.blocked == blocked


def test_a_palm_below_something_is_drawn_back_first(robot: Robot) -> None:
    table = box("table", (0.5, 0.0, 0.0), (0.8, 2.0, 0.04))
    robot.begin_tick(hand_at((0.4, 0.2, -0.15)), {"table": table})
    back = way_of(robot).next("left", [0.8, 0.2, 0.3])
    assert back[0] < 0.2 and back[2] == -0.15
