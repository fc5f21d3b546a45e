"""Ways: how long they are and how far they turn, where they may end, and when they are planned anew."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.robot import Robot
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
    robot: Robot, place: tuple[float, float], up_to: bool, past: bool
) -> None:
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
def test_a_place_that_is_none_is_refused(robot: Robot, places: Any, said: str) -> None:
    robot.begin_tick(make_state(), {})
    route = Route(RobotHandle(robot, "walk", ("base",)))
    for ask in (route.free, route.nearest):
        with pytest.raises(ValueError, match=re.escape(said)):
            ask(places)


def test_of_no_places_none_is_free_or_nearest_whatever_was_seen(robot: Robot) -> None:
    route = Route(RobotHandle(robot, "walk", ("base",)))
    for percepts in ({}, {"box": Percept("box", 0.0, np.array([2.0, 0.0, -0.4]), 0.9, np.full(3, 0.5))}):
        robot.begin_tick(make_state(), percepts)
        assert route.free([]) == []
        assert route.nearest([], []) is None


@pytest.mark.parametrize(
    ("place", "heading"), [((math.nan, 0.0), 0.0), ((3.0, math.inf), 0.0), ((3.0, 0.0), math.nan), ((1e5, 0.0), 0.0)]
)
@pytest.mark.parametrize("beside", [True, False])
def test_no_way_leads_to_what_is_no_place(
    robot: Robot, place: tuple[float, float], heading: float, beside: bool
) -> None:
    route = Route(RobotHandle(robot, "walk", ("base",)))
    bench = Percept("bench", 0.0, np.array([2.0, 0.0, -0.4]), 0.9, np.array([0.3, 2.0, 0.7]))
    robot.begin_tick(make_state(), {"bench": bench} if beside else {})
    with pytest.raises(ValueError, match=r"must be (finite|within)"):
        route.follow(place, heading)


class Walker:
    """A robot that stands where it is put, and follows a way in every tick of 0.1 s."""

    def __init__(self, **values: object) -> None:
        self.robot = make_robot(clock := CycleClock())
        self.clock, self.ticks = clock, 0
        self.handle = RobotHandle(self.robot, "walk", ("base",))
        self.radius = self.robot.config.walking_radius
        self.route = Route(self.handle, **values)  # type: ignore[arg-type]  # as the test gives them

    def see(self, *seen: Percept, at: Sequence[float] = (0.0, 0.0, 0.0)) -> None:
        """Begin a tick in which it stands somewhere and sees things; those seen before are remembered."""
        now = self.ticks / 10
        self.clock.cycle, self.ticks = 100 * self.ticks, self.ticks + 1
        base = np.array([at[0], at[1], 0.0])
        turn = np.array([math.cos(at[2] / 2), 0.0, 0.0, math.sin(at[2] / 2)])
        state = dataclasses.replace(
            make_state(now), stance=np.array(at, dtype=float), base_position=base, base_quaternion=turn
        )
        cos, sin = math.cos(at[2]), math.sin(at[2])
        into = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]])
        percepts = {
            one.name: dataclasses.replace(
                one, stamp=now, position=into @ (one.position - base), heading=one.heading - at[2]
            )
            for one in seen
        }
        self.robot.begin_tick(state, percepts)

    def plans(self) -> list[float]:
        """Return a list of the times at which a way is planned from now on [s]."""
        made, make = list[float](), self.route._make_plan

        def noted(*given: Any) -> None:
            made.append(self.clock.now())
            make(*given)

        self.route._make_plan = noted  # type: ignore[method-assign]  # to hear of it
        return made

    @property
    def target(self) -> np.ndarray | None:
        """Where it is sent."""
        found = self.handle.targets.get("base")
        return None if found is None else found.position  # type: ignore[union-attr]  # it is of the base


def box(name: str, x: float, y: float, length: float, width: float, confidence: float = 0.9) -> Percept:
    return Percept(name, 0.0, np.array([x, y, -0.4]), confidence, np.array([length, width, 0.7]))


def walled_in(name: str, far: float) -> list[Percept]:
    """Return walls all round (4, 0), this far from it [m]."""
    return [
        box(f"{name}{number}", 4 + x * far, y * far, *((0.1, 2 * far) if x else (2 * far, 0.1)))
        for number, (x, y) in enumerate([(1, 0), (0, 1), (-1, 0), (0, -1)])
    ]


def test_cuts_a_corner_by_some_of_its_clearance_and_no_more() -> None:
    for aside, straight in ((0.055, True), (0.04, False)):
        walker = Walker(clearance=0.08)
        walker.see(box("box", 1.0, 0.2 + walker.radius + aside, 0.4, 0.4))
        assert walker.route.is_straight((2.0, 0.0)) == straight


def test_is_sent_so_far_that_it_walks_on_round_a_corner_and_gets_there() -> None:
    walker, here = Walker(), np.zeros(3)
    bench, near = box("bench", 1.0, 0.0, 0.1, 1.0), walker.robot.config.gait.near
    for _ in range(300):
        walker.see(bench, at=here)
        assert walker.route.follow((2.0, 0.0), 0.0)
        assert walker.target is not None
        way = walker.target - here[:2]
        if not walker.route.is_straight((2.0, 0.0)):
            assert np.linalg.norm(way) > near + 0.09
        if np.linalg.norm(way) < 0.02:
            break
        here[:2] += 0.02 * way / np.linalg.norm(way)
    assert math.dist(here[:2], (2.0, 0.0)) < 0.03


def test_plans_anew_where_it_was_pushed_off_its_way() -> None:
    walker = Walker()
    bench = box("bench", 1.0, -0.1, 0.1, 1.0)  # shorter past its left end
    walker.see(bench)
    assert walker.route.follow((2.0, 0.0), 0.0)
    assert walker.target is not None and walker.target[1] > 0.1
    walker.see(bench, at=(0.6, -1.3, 0.0))
    assert walker.route.follow((2.0, 0.0), 0.0)
    assert walker.route.to_go < 2.2  # past its right end, and not back to the other one


def test_plans_anew_where_it_goes_elsewhere_or_something_comes_to_stand_on_its_way() -> None:
    walker = Walker()
    plans, bench = walker.plans(), box("bench", 1.0, -0.1, 0.1, 1.0)
    left = box("left", 1.0, 1.5, 0.1, 2.2)
    for seen, goal, ends in (
        ([bench], (2.0, 0.0), 1),
        ([bench], (2.0, 0.01), 1),  # hardly elsewhere
        ([bench], (2.0, -0.3), 2),
        ([bench, left], (2.0, -0.3), 3),
        ([bench, left], (2.0, -0.3), 3),
    ):
        walker.see(*seen)
        assert walker.route.follow(goal, 0.0)
        assert len(plans) == ends
        assert walker.handle.route is not None
        assert math.dist(walker.handle.route[-1], goal) < 0.03
    assert walker.target is not None and walker.target[1] < -0.1


def test_plans_anew_where_it_was_pushed_off_a_straight_way() -> None:
    walker, bench = Walker(), box("bench", 1.0, -0.1, 0.1, 1.0)
    plans = walker.plans()
    for at, ends in (((0.0, 0.0, 0.0), 1), ((0.0, 3.0, 0.0), 1), ((0.0, 0.0, 0.0), 2)):
        walker.see(bench, at=at)
        assert walker.route.follow((2.0, 0.0), 0.0)
        assert len(plans) == ends


def test_looks_for_a_way_where_there_was_none_again_and_again_but_not_in_every_tick() -> None:
    walker = Walker()
    plans, walls = walker.plans(), walled_in("wall", 1.0)
    for _ in range(10):
        walker.see(*walls)
        assert not walker.route.follow((4.0, 0.0), 0.0)
    assert plans == pytest.approx([0.0, 0.3, 0.6, 0.9])


def test_has_new_patience_each_time_it_is_blocked() -> None:
    walker, goal = Walker(), (2.0, 0.0)
    for told in ("box", "crate"):
        for _ in range(8):
            walker.see(box(told, 2.0, 0.0, 0.4, 0.4))
            assert not walker.route.follow(goal, 0.0)
            assert walker.route.blocked == f"{told} stands there, or too near to it"
            assert not walker.route.hopeless
        walker.see(box(told, 2.0, 0.0, 0.4, 0.4, confidence=0.0))
        assert walker.route.follow(goal, 0.0)
        assert walker.route.blocked == ""
        assert not walker.route.hopeless


def test_forgets_where_it_stepped_aside_to_once_it_walks_on() -> None:
    walker = Walker()

    def follows(x: float, y: float = 0.0) -> bool:
        walker.see(box("cart", 2.4 - 0.05 * walker.ticks, 0.0, 0.3, 0.3), at=(0.0, y, 0.0))
        return walker.route.follow((x, 0.0), 0.0)

    while walker.target is None or walker.target[0] > 0.1:
        follows(3.0)
    assert walker.target[1] == pytest.approx(0.55, abs=0.05)
    assert follows(-3.0)
    assert not follows(3.0, y=-0.013)
    assert walker.target[1] == pytest.approx(-0.55, abs=0.05)  # the nearer side from there


def test_leaves_what_it_stands_beside_and_does_not_come_nearer_to_it() -> None:
    walker = Walker()
    walker.see(box("box", 0.2 + walker.radius - 0.05, 0.0, 0.4, 1.0))
    assert walker.route.hits((-0.5, 0.0)) == ""
    assert walker.route.hits((0.05, 0.0)) == "box"


@pytest.mark.parametrize(("nearer", "beside"), [(0.01, ""), (0.03, "box")])
def test_turns_within_a_little_less_than_its_radius(nearer: float, beside: str) -> None:
    walker = Walker()
    walker.see(box("box", 0.2 + walker.radius - nearer, 0.0, 0.4, 0.4))
    assert walker.route.beside() == beside


def test_names_what_is_in_the_way_where_no_thing_alone_is() -> None:
    walker, rings = Walker(), [*walled_in("inner", 1.0), *walled_in("outer", 2.0)]
    for _ in range(13):
        walker.see(*rings)
        assert not walker.route.follow((4.0, 0.0), 0.0)
    assert walker.route.hopeless
    assert "inner" in walker.route.blocked or "outer" in walker.route.blocked


@pytest.mark.parametrize(("far", "walks"), [(3.5, True), (0.9, False)])
def test_walks_on_where_something_just_passes_far_ahead(far: float, walks: bool) -> None:
    walker = Walker()
    for tick in range(15):
        walker.see(box("cart", far, 0.15 * (tick - 14), 0.3, 0.3))
        follows = walker.route.follow((far, 0.0), 0.0)
    assert "cart" in walker.route._around.movers
    assert follows == walks


@pytest.mark.parametrize("room", [True, False])
def test_turns_to_what_it_waits_for_if_it_has_room_to(room: bool) -> None:
    walker = Walker()
    wall = [] if room else [box("wall", 0.0, -0.2 - walker.radius + 0.03, 1.0, 0.4)]
    for tick in range(31):
        cart = [box("cart", 0.9, 0.05 * min(tick - 15, 0), 0.3, 0.3)] if tick < 22 else []
        walker.see(*wall, *cart)
        assert not walker.route.follow((0.9, 0.0), 0.0) or tick < 12
    assert walker.route.blocked == "cart stands there, or too near to it"
    assert (walker.target is not None) == room
