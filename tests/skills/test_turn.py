"""The skill ``turn``, alone on the simulated robot."""

import math
import re
from collections.abc import Callable

import numpy as np
import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt import Gait, Rig


@pytest.mark.parametrize(
    "angle", [-0.6, *(pytest.param(angle, marks=pytest.mark.trials) for angle in (0.6, -1.2, math.pi))]
)
def test_turns_on_the_spot_to_the_side_it_is_told(rig: Rig, angle: float) -> None:
    result = rig.run("turn", angle=angle, timeout=15)
    assert result.succeeded, result.feedback
    headings = np.unwrap([state.stance[2] for state in result.states])
    assert headings[-1] - headings[0] == pytest.approx(angle, abs=0.08)
    assert max(np.linalg.norm(state.stance[:2]) for state in result.states) < 0.06
    assert not result.stops


@pytest.mark.trials
def test_counts_from_where_it_faces_at_each_start(rig: Rig) -> None:
    for _ in range(2):
        assert rig.run("turn", angle=0.5).succeeded
    assert rig.state.stance[2] == pytest.approx(1.0, abs=0.16)


def test_goes_the_long_way_round(rig: Rig) -> None:
    result = rig.run("turn", angle=1.3 * math.pi, timeout=2.0)
    assert result.states[-1].stance[2] > 0.3
    assert result.feedback.endswith("deg to go")


def test_does_not_step_for_an_angle_within_the_tolerance(rig: Rig) -> None:
    result = rig.run("turn", angle=0.05)
    assert result.succeeded
    assert result.feedback == "turned 0 deg"
    assert all(state.gait is Gait.STAND for state in result.states)


def test_gives_up_when_it_turns_no_farther(rig: Rig) -> None:
    rig.raise_estop()
    result = rig.run("turn", angle=1.0, patience=1.0)
    assert result.failed
    assert result.feedback == "turns no farther: 57 deg to go"


def test_comes_back_to_its_spot_when_it_is_pushed_as_it_turns(rig: Rig) -> None:
    for time in (0.8, 1.6, 2.4):
        rig.at(time, lambda: rig.push((70, 0, 0), duration=0.2))
    result = rig.run("turn", angle=3.0, timeout=15)
    assert result.succeeded, result.feedback
    assert np.hypot(*rig.state.stance[:2]) < 0.04


def test_a_robot_that_has_turned_far_enough_but_steps_on_comes_to_rest_there(rig: Rig) -> None:
    rig.at(0.7, lambda: rig.push((0.0, 180.0, 0.0), 0.1, "torso"))
    result = rig.run("turn", angle=0.6, patience=0.6, timeout=15)
    assert result.succeeded, result.feedback
    assert result.time > 2.0  # it steps for longer than its patience


def test_stops_when_halted(rig: Rig) -> None:
    result = rig.run("turn", angle=3.0, timeout=1.5)
    assert result.states[-1].gait is Gait.STEP
    facing = rig.state.stance[2]
    settled = rig.settle(2.5)
    assert settled.base_settled
    assert settled.stance[2] - facing < 0.6


@pytest.mark.parametrize("angle", [0.0, 0.07, -0.07])
def test_takes_no_step_where_it_faces(rig: Rig, angle: float) -> None:
    result = rig.run("turn", angle=angle)
    assert result.succeeded, result.feedback
    assert result.time <= 0.3
    assert {state.gait for state in result.states} == {Gait.STAND}
    assert result.results["turned"] == pytest.approx(0, abs=0.01)


def test_says_that_a_robot_that_stands_makes_no_step_for_so_little(rig: Rig) -> None:
    rig.settle(0.5)
    result = rig.run("turn", angle=0.05, tolerance=0.01, patience=0.5)
    assert result.failed
    assert result.feedback == "turns no farther: 3 deg to go, for which it makes no step"
    result = rig.run("turn", angle=0.004, tolerance=0.0001, patience=0.5)
    assert re.fullmatch(r"turns no farther: 0\.[1-9] deg to go, for which it makes no step", result.feedback)


def test_says_how_far_it_turned_whatever_angle_is_set_meanwhile(session_of: Callable[[str], hbt.Session]) -> None:
    with session_of("turn: {angle: 60 deg}") as session:
        session.run_until(1.0)
        session.set("turn.angle", "170 deg")
        session.run_until(lambda s: s.node("turn").status is not Status.RUNNING, timeout=10)
        turned = session.node("turn").results["turned"]
        assert turned == pytest.approx(session.state.stance[2], abs=0.03)
