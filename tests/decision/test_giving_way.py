"""When a robot lets pass what moves, and where it steps aside."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.giving_way import GivingWay
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.surroundings import Surroundings
from humanoid_bt.robot.config import GaitConfig
from tests.decision.watched import watched
from tests.tree.helpers import make_state

HERE, AHEAD = np.zeros(2), np.array([3.0, 0.0])
ROOM, HALF = 0.4, 0.2  # m: how near a cart may come, and half of its width
GAIT = GaitConfig(step_forward=0.3, single_support=0.4, double_support=0.1)  # 0.6 m/s
SINCE = 1.0  # s for which the cart was seen


def way_of(x: float, y: float, vx: float = 0.0, vy: float = 0.0, box: tuple[float, float] | None = None) -> GivingWay:
    """Return the giving way to a cart that is here, and moves, and to a box that stands."""
    size = np.array([2 * HALF, 2 * HALF, 0.8])

    def seen(time: float) -> list[Percept]:
        place = np.array([x + vx * (time - SINCE), y + vy * (time - SINCE), -0.4])
        boxes = [Percept("box", time, np.array([*box, -0.4]), 0.9, size)] if box else []
        return [Percept("cart", time, place, 0.9, size), *boxes]

    return GivingWay(watched(seen, until=SINCE), GAIT, ROOM)


@pytest.mark.parametrize(
    ("x", "y", "vy", "met"),
    [
        pytest.param(1.2, 1.2, -0.5, True, id="crosses the way when the robot is there"),
        pytest.param(1.2, -1.2, -0.5, False, id="has crossed it"),
        pytest.param(1.2, 2.9, -0.5, False, id="will cross it behind the robot"),
        pytest.param(1.2, 0.9, -1.5, False, id="is gone when the robot comes"),
        pytest.param(2.3, 1.6, -0.5, False, id="crosses it where the robot can still stop later"),
    ],
)
def test_lets_pass_only_what_it_would_meet(x: float, y: float, vy: float, met: bool) -> None:
    assert way_of(x, y, vy=vy).would_meet(HERE, AHEAD) == (["cart"] if met else [])


def test_follows_what_is_too_near_and_leaves() -> None:
    assert way_of(0.5, 0.0, vx=1.0).would_meet(HERE, AHEAD) == []


def test_does_not_wait_for_what_stands() -> None:
    assert way_of(1.2, 0.0).would_meet(HERE, AHEAD) == []


def test_does_not_let_pass_what_crosses_beyond_where_it_goes() -> None:
    assert way_of(1.2, 1.2, vy=-0.5).would_meet(HERE, np.array([0.3, 0.0])) == []


def test_lets_pass_what_comes_to_where_it_goes_later_than_it_does() -> None:
    assert way_of(0.5, 1.6, vy=-0.5).would_meet(HERE, np.array([0.5, 0.0])) == ["cart"]


def test_steps_out_of_the_way_by_as_much_as_it_needs() -> None:
    place = way_of(1.2, 0.0, vx=-0.25).aside(HERE)
    assert place is not None
    assert abs(place[1]) == pytest.approx(ROOM + HALF, abs=0.03)  # a step back, and the cart would come 3 s later


def test_does_not_step_to_where_something_stands() -> None:
    place = way_of(1.2, 0.0, vx=-0.25, box=(0.0, 1.0)).aside(HERE)
    assert place is not None
    assert place[1] == pytest.approx(-ROOM - HALF, abs=0.03)
    place = way_of(1.2, 0.0, vx=-0.25, box=(0.0, -1.0)).aside(HERE)
    assert place is not None
    assert place[1] == pytest.approx(ROOM + HALF, abs=0.03)


def test_steps_back_where_there_is_no_time_to_step_out_of_the_way() -> None:
    place = way_of(1.6, 0.0, vx=-0.5).aside(HERE)
    assert place is not None
    assert place[0] < -0.3
    assert place[1] == pytest.approx(0.0, abs=0.1)


def test_stays_where_nothing_comes() -> None:
    assert way_of(1.6, 0.8, vx=-0.5).aside(HERE) is None
    assert way_of(1.6, 0.0, vx=0.5).aside(HERE) is None
    assert way_of(0.5, 0.0, vx=0.5).aside(HERE) is None  # too near, and leaves


def test_goes_on_to_the_place_that_it_has_chosen() -> None:
    way = way_of(1.2, 0.0, vx=-0.25)
    chosen, on = way.aside(HERE), np.array([0.0, -0.013])
    assert chosen is not None
    np.testing.assert_array_equal(way.aside(on), chosen)
    way.walk_on()
    again = way.aside(on)
    assert again is not None
    assert np.abs(again - chosen).max() > 0.01


def test_has_nowhere_to_go_from_what_is_too_quick() -> None:
    assert way_of(2.5, 0.0, vx=-1.5).aside(HERE) is None


def test_steps_away_from_what_is_too_near_as_far_as_it_must() -> None:
    way = way_of(0.5, 0.0)
    place = way.away(HERE, ignore=())
    assert place is not None
    assert np.hypot(*(place - [0.5 - HALF, 0.0])) == pytest.approx(ROOM, abs=0.06)
    assert way.away(HERE, ignore=("cart",)) is None
    assert way_of(0.7, 0.0).away(HERE, ignore=()) is None
    assert way_of(HALF + ROOM - 0.02, 0.0).away(HERE, ignore=()) is None  # not for so little


def test_steps_away_from_one_thing_and_not_as_far_from_all() -> None:
    place = way_of(0.5, 0.0, box=(-0.75, 0.0)).away(HERE, ignore=())
    assert place is not None
    assert place[0] < 0


def test_a_robot_that_stands_deep_in_something_steps_toward_where_it_ends(robot: Robot) -> None:
    robot.begin_tick(
        make_state(), {"crowd": Percept("crowd", 0.0, np.array([1.0, 0.0, 0.0]), 0.9, np.array([4.0, 4.0, 1.0]))}
    )
    around = Surroundings(RobotHandle(robot, "walk", ("base",)))
    around.look()
    away = GivingWay(around, GaitConfig(), 0.4).away(np.zeros(2), ())
    assert away is not None
    assert away.tolist() == pytest.approx([-0.05, 0.0])
