"""Places and percepts as a robot takes them: what is no place, how large a thing is, where it points."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.route import Route
from humanoid_bt.decision.surroundings import Surroundings
from tests.tree.helpers import make_robot, make_state


@pytest.mark.parametrize(
    ("place", "heading"), [((math.nan, 0.0), 0.0), ((3.0, math.inf), 0.0), ((3.0, 0.0), math.nan), ((1e5, 0.0), 0.0)]
)
@pytest.mark.parametrize("beside", [True, False])
def test_no_way_leads_to_what_is_no_place(place: tuple[float, float], heading: float, beside: bool) -> None:
    robot = make_robot(CycleClock())
    route = Route(RobotHandle(robot, "walk", ("base",)))
    bench = Percept("bench", 0.0, np.array([2.0, 0.0, -0.4]), 0.9, np.array([0.3, 2.0, 0.7]))
    robot.begin_tick(make_state(), {"bench": bench} if beside else {})
    with pytest.raises(ValueError, match=r"must be (finite|within)"):
        route.follow(place, heading)


def test_what_is_told_to_be_gone_again_and_again_has_the_size_that_it_had() -> None:
    robot = make_robot(clock := CycleClock())
    around = Surroundings(RobotHandle(robot, "walk", ("base",)))
    cart = Percept("cart", 0.0, np.array([2.0, -1.0, -0.4]), 0.9, np.array([1.6, 1.6, 0.7]))
    for tick in range(25):
        now = tick / 10
        clock.cycle = 100 * tick
        seen = dataclasses.replace(cart, stamp=now, position=np.array([2.0, -1.0 + 0.5 * min(now, 1.9), -0.4]))
        if tick >= 20:
            seen = dataclasses.replace(seen, confidence=0.0, size=None)
        robot.begin_tick(make_state(now), {"cart": seen})
        around.look()
    assert around.obstacles.halves.tolist() == [[0.8, 0.8]]  # it goes on, as large as it is


def test_a_box_points_within_half_a_turn() -> None:
    robot = make_robot(CycleClock())
    turned = dataclasses.replace(make_state(), base_quaternion=np.array([math.cos(1.5), 0.0, 0.0, math.sin(1.5)]))
    robot.begin_tick(turned, {"box": Percept("box", 0.0, np.ones(3), 0.9, np.ones(3), heading=1.0)})
    box = robot.track("box")
    assert box is not None
    assert box.heading_world == pytest.approx(4.0 - math.tau)
