"""The skill ``walk_to``, alone on the simulated robot."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt import Gait, Rig
from humanoid_bt.core.messages import BaseTarget
from humanoid_bt.decision.robot_handle import RobotHandle


@pytest.mark.parametrize(
    ("x", "y", "heading"), [(0.5, 0.0, 0.5), pytest.param(-0.2, 0.15, -0.6, marks=pytest.mark.trials)]
)
def test_stands_at_the_place_and_faces_where_it_is_told(rig: Rig, x: float, y: float, heading: float) -> None:
    result = rig.run("walk_to", x=x, y=y, heading=heading)
    assert result.succeeded, result.feedback
    stance = rig.state.stance
    assert math.hypot(stance[0] - x, stance[1] - y) < 0.06
    assert stance[2] == pytest.approx(heading, abs=0.12)
    assert not result.stops


@pytest.mark.trials
def test_faces_where_it_walked_to_without_a_heading(rig: Rig) -> None:
    result = rig.run("walk_to", x=0.4, y=0.4)
    assert result.succeeded, result.feedback
    assert rig.state.stance[2] == pytest.approx(math.pi / 4, abs=0.12)


def test_keeps_its_heading_when_the_place_is_near(rig: Rig) -> None:
    result = rig.run("walk_to", x=0.0, y=-0.2)
    assert result.succeeded, result.feedback
    assert rig.state.stance[2] == pytest.approx(0.0, abs=0.12)


@pytest.mark.trials
def test_turns_round_to_a_place_behind(rig: Rig) -> None:
    result = rig.run("walk_to", x=-1.5, y=0.0, timeout=20)
    assert result.succeeded, result.feedback
    assert rig.state.stance[0] == pytest.approx(-1.5, abs=0.06)
    assert abs(rig.state.stance[2]) == pytest.approx(math.pi, abs=0.12)


def test_succeeds_at_once_when_it_is_there(rig: Rig) -> None:
    rig.settle(0.5)
    result = rig.run("walk_to", x=0.0, y=0.0)
    assert result.succeeded
    assert all(state.gait is Gait.STAND for state in result.states)


def test_gives_up_when_it_comes_no_nearer(rig: Rig) -> None:
    rig.raise_estop()
    result = rig.run("walk_to", x=1.0, y=0.0, patience=1.0)
    assert result.failed
    assert result.feedback == "comes no nearer: 1.00 m and 0 deg to go"


def test_has_new_patience_to_come_to_rest_where_it_is_to_stand(rig: Rig) -> None:
    result = rig.run("walk_to", x=0.5, y=0.0, patience=0.7)
    assert result.succeeded, result.feedback


def test_gives_up_where_it_is_to_stand_if_it_steps_on_and_on(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    seen = RobotHandle.state.fget
    assert seen is not None
    steps = property(lambda robot: replace(seen(robot), gait=Gait.STEP, base_settled=False))
    monkeypatch.setattr(RobotHandle, "state", steps)
    result = rig.run("walk_to", x=0.04, y=0.0, patience=0.2, timeout=2.0)
    assert result.failed
    assert result.feedback.startswith("comes no nearer: ")
    assert result.time == pytest.approx(3 * 0.2 + 0.2, abs=0.05)


def test_has_patience_for_as_long_as_it_turns_on_the_spot(rig: Rig) -> None:
    result = rig.run("walk_to", x=0.0, y=0.0, heading=2.5, patience=1.0, timeout=15)
    assert result.succeeded, result.feedback


def test_comes_nearer_although_it_turns_away_to_go_backward(rig: Rig) -> None:
    result = rig.run("walk_to", x=-0.9, y=0.9, heading=math.radians(-45), patience=1.5, timeout=20)
    assert result.succeeded, result.feedback
    assert all(abs(state.stance[2]) < math.radians(60) for state in result.states), "it would not have gone backward"


def test_stops_within_a_step_when_halted(rig: Rig) -> None:
    result = rig.run("walk_to", x=3.0, y=0.0, timeout=2.5)
    assert result.states[-1].gait is Gait.STEP
    where = rig.state.stance[0]
    settled = rig.settle(2.5)
    assert settled.base_settled
    assert settled.stance[0] - where < 0.35


@pytest.mark.parametrize("settled", [False, True])
def test_takes_no_step_where_it_stands(rig: Rig, settled: bool) -> None:
    if settled:
        rig.settle(0.5)
    result = rig.run("walk_to", x=0.04, y=0.02)
    assert result.succeeded, result.feedback
    assert result.time <= (0.0 if settled else 0.3)
    assert {state.gait for state in result.states} == {Gait.STAND}
    assert result.results["position_error"] == pytest.approx(math.hypot(0.04, 0.02), abs=0.002)
    assert result.results["heading_error"] == pytest.approx(0, abs=0.01)


BOX, RADIUS = (0.3, 0.3, 0.8), 0.38


def test_goes_round_what_is_solid(rig: Rig) -> None:
    rig.see("box", (0.8, 0.0, 0.4), size=BOX)
    result = rig.run("walk_to", x=1.6, y=0.0, timeout=20)
    assert result.succeeded, result.feedback
    apart = [math.hypot(*(np.abs(state.stance[:2] - [0.8, 0.0]) - 0.15).clip(0)) for state in result.states]
    assert min(apart) > RADIUS
    walking = [state.gait for state in result.states if 0.4 < state.stance[0] < 1.2]
    assert set(walking) == {Gait.STEP}  # it does not stop at the corners


def test_has_no_way_to_where_something_stands(rig: Rig) -> None:
    rig.see("box", (0.8, 0.0, 0.4), size=BOX)
    result = rig.run("walk_to", x=0.8, y=0.1)
    assert result.failed
    assert result.feedback == "no way to (0.8, 0.1): box stands there, or too near to it"
    assert result.time < 2
    assert {state.gait for state in result.states} == {Gait.STAND}


@pytest.mark.trials
def test_goes_round_a_percept_without_a_size_if_it_is_told_to(rig: Rig) -> None:
    rig.see("person", (0.3, 0.0, 0.8))
    assert rig.run("walk_to", x=0.2, y=0.0, obstacles=["person"]).feedback.startswith("no way to (0.2, 0): person")
    assert rig.run("walk_to", x=0.2, y=0.0).succeeded


def test_walks_below_what_hangs_overhead(rig: Rig) -> None:
    rig.see("lamp", (0.2, 0.0, 2.0), size=BOX)
    assert rig.run("walk_to", x=0.2, y=0.0).succeeded


def test_steps_away_from_what_has_come_too_near(rig: Rig) -> None:
    rig.see("box", (0.4, 0.0, 0.4), size=BOX)
    result = rig.run("walk_to", x=-0.5, y=0.0, heading=0.0, timeout=3)
    xs = [float(state.stance[0]) for state in result.states]
    assert max(xs) < 0.03
    assert xs[-1] < -0.1


def test_waits_for_what_comes_at_it_and_says_so(rig: Rig) -> None:
    rig.see("cart", (2.0, 0.0, 0.4), size=BOX)
    for tick in range(1, 60):
        rig.at(0.02 * tick, lambda x=2.0 - 0.02 * tick: rig.see("cart", (x, 0.0, 0.4), size=BOX))
    result = rig.run("walk_to", x=3.0, y=0.0, timeout=1.2)
    assert result.feedback == "waiting: cart is in the way"
    assert "base" not in result.commands[-1].targets


def test_turns_to_where_what_left_its_view_should_be_by_now(rig: Rig) -> None:
    for tick in range(41):  # seen for a second, then remembered
        place = 1.5, 1.3 - 0.03 * min(tick, 10), 0.4
        confidence = 0.9 if tick <= 10 else 0.08
        rig.at(0.1 * tick, lambda place=place, sure=confidence: rig.see("cart", place, sure, size=BOX))
    result = rig.run("walk_to", x=3.0, y=0.0, timeout=3.5)
    assert result.feedback == "waiting: cart is in the way"
    here, now = rig.state.stance, rig.state.time
    by_now = math.atan2(1.3 - 0.3 * now - here[1], 1.5 - here[0])
    target = result.commands[-1].targets["base"]
    assert isinstance(target, BaseTarget)
    assert target.heading == pytest.approx(by_now, abs=0.05)


def test_steps_aside_from_what_comes_to_where_it_waits(rig: Rig) -> None:
    def place(time: float) -> tuple[float, float, float]:
        return 2.2 - 0.45 * time, -1.2 + 0.27 * time, 0.4

    for tick in range(60):
        rig.at(0.1 * tick, lambda time=0.1 * tick: rig.see("cart", place(time), size=BOX))
    result = rig.run("walk_to", x=3.0, y=0.0, timeout=6)
    apart = [math.hypot(*(np.abs(state.stance[:2] - place(state.time)[:2]) - 0.15).clip(0)) for state in result.states]
    assert min(apart) > 0.9 * RADIUS


def test_says_that_a_robot_that_stands_makes_no_step_for_so_little(rig: Rig) -> None:
    rig.settle(0.5)
    result = rig.run("walk_to", x=0.03, y=0.0, heading=0.0, tolerance=0.01, patience=0.5)
    assert result.failed
    assert result.feedback == "comes no nearer: 0.03 m and 0 deg to go, for which it makes no step"


def test_says_where_it_walked_to_whatever_place_is_set_meanwhile(session_of: Callable[[str], hbt.Session]) -> None:
    with session_of("walk_to: {x: 0.4, y: 0}") as session:
        session.run_until(1.0)
        session.set("walk_to.x", 5)
        session.run_until(lambda s: s.node("walk_to").status is not Status.RUNNING, timeout=10)
        assert "from (0.4, 0)" in session.node("walk_to").feedback
