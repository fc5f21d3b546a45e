"""The skill ``approach``, alone on the simulated robot."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from humanoid_bt import Gait, Rig, RigResult
from humanoid_bt.core.messages import BaseTarget
from humanoid_bt.decision.robot_handle import RobotHandle


def bases_of(result: RigResult) -> list[BaseTarget]:
    return [base for command in result.commands if isinstance(base := command.targets.get("base"), BaseTarget)]


@pytest.mark.parametrize(("distance", "bearing"), [pytest.param(1.0, 0.0, marks=pytest.mark.trials), (0.9, 1.2)])
def test_walks_up_to_the_target_and_faces_it(rig: Rig, distance: float, bearing: float) -> None:
    target = np.array([distance * math.cos(bearing), distance * math.sin(bearing), 0.9])
    result = rig.run("approach", target=target, distance=0.4, timeout=15)
    assert result.succeeded, result.feedback
    x, y, heading = rig.state.stance
    assert math.hypot(target[0] - x, target[1] - y) == pytest.approx(0.4, abs=0.08)
    assert math.atan2(target[1] - y, target[0] - x) == pytest.approx(heading, abs=0.13)
    assert not result.stops


def test_succeeds_at_once_when_it_is_there(rig: Rig) -> None:
    rig.settle(0.5)
    result = rig.run("approach", target=(0.4, 0.0, 0.9), distance=0.4)
    assert result.succeeded
    assert result.time < 0.5
    assert all(state.gait is Gait.STAND for state in result.states)


def test_looks_at_the_target_while_it_walks(rig: Rig) -> None:
    target = np.array([1.0, 0.5, 0.9])
    result = rig.run("approach", target=target, timeout=3)
    to_target = target - result.states[-1].gaze_position
    aligned = result.states[-1].gaze_direction @ to_target / np.linalg.norm(to_target)
    assert aligned > math.cos(math.radians(12))


@pytest.mark.trials
def test_stops_within_a_step_when_halted(rig: Rig) -> None:
    result = rig.run("approach", target=(3.0, 0.0, 0.9), timeout=3)
    assert result.states[-1].gait is Gait.STEP
    where = rig.state.stance[0]
    settled = rig.settle(2.5)
    assert settled.base_settled
    assert settled.stance[0] - where < 0.35


@pytest.mark.trials
def test_follows_a_target_that_moves(rig: Rig) -> None:
    rig.at(1.5, lambda: rig.see("target", (0.9, 0.6, 0.9)))
    result = rig.run("approach", target=(1.0, 0.0, 0.9), distance=0.4, timeout=15)
    assert result.succeeded, result.feedback
    x, y, _ = rig.state.stance
    assert math.hypot(0.9 - x, 0.6 - y) == pytest.approx(0.4, abs=0.08)


def test_fails_when_the_target_was_never_seen(rig: Rig) -> None:
    result = rig.run("approach", target="nothing")
    assert result.failed
    assert "'nothing' was never seen: perception offers no such percept" in result.feedback


def test_takes_no_step_when_it_is_there_already(rig: Rig) -> None:
    result = rig.run("approach", target=(0.44, 0.0, 0.9), distance=0.4)
    assert result.succeeded, result.feedback
    assert result.time <= 0.3
    assert {state.gait for state in result.states} == {Gait.STAND}
    assert result.results["target_distance"] == pytest.approx(0.44, abs=0.005)
    assert result.results["bearing_error"] == pytest.approx(0, abs=0.02)


@pytest.mark.trials
def test_leaves_the_gaze_alone_when_it_is_not_to_look(rig: Rig) -> None:
    result = rig.run("approach", target=(0.8, 0.0, 0.9), look=False)
    assert result.succeeded, result.feedback
    assert not any("gaze" in command.targets for command in result.commands)


def test_stands_as_near_as_it_can(rig: Rig) -> None:
    rig.see("table", (1.1, 0.0, 0.35), size=(0.6, 6.0, 0.7))
    result = rig.run("approach", target=(1.0, 0.0, 0.9), timeout=15)
    assert result.succeeded, result.feedback
    assert 0.8 - rig.state.stance[0] == pytest.approx(0.4, abs=0.08)  # its walking_radius and 2 cm


@pytest.mark.parametrize("length", [0.6, 3.0], ids=["box", "stage"])
def test_stands_as_near_as_it_can_to_a_large_target(rig: Rig, length: float) -> None:
    rig.settle(0.5)
    rig.see("target", (0.2 + length / 2, 0.0, 0.35), size=(length, length, 0.7))
    result = rig.run("approach", target="target", distance=0.4)
    assert result.succeeded, result.feedback
    assert {state.gait for state in result.states} == {Gait.STAND}


def test_walks_round_the_target_to_where_it_comes_nearest(rig: Rig) -> None:
    rig.see("bench", (1.1, 0.0, 0.35), size=(1.2, 0.3, 0.7))
    result = rig.run("approach", target="bench", distance=0.4, timeout=20)
    assert result.succeeded, result.feedback
    stances = np.array([state.stance[:2] for state in result.states])
    away = np.linalg.norm(np.maximum(np.abs(stances - [1.1, 0.0]) - [0.6, 0.15], 0.0), axis=1)
    assert away.min() > 0.15
    assert result.results["target_distance"] == pytest.approx(0.4, abs=0.07)


def test_says_what_is_in_the_way(rig: Rig) -> None:
    rig.see("hall", (3.0, 0.0, 0.35), size=(5.0, 5.0, 0.7))
    result = rig.run("approach", target=(3.0, 0.0, 0.9))
    assert result.failed
    assert result.feedback == "no way to target: hall stands there, or too near to it"


def test_says_that_a_robot_that_stands_makes_no_step_for_so_little(rig: Rig) -> None:
    rig.settle(0.5)
    result = rig.run("approach", target=(0.43, 0.0, 0.9), distance=0.4, tolerance=0.005, patience=0.5)
    assert result.failed
    assert result.feedback == "comes no nearer: 0.03 m and 0 deg to go, for which it makes no step"


def test_the_place_to_stand_at_does_not_wander_with_the_robot(rig: Rig) -> None:
    result = rig.run("approach", target=(0.8, 0.5, 0.9), distance=0.4, timeout=15)
    assert result.succeeded, result.feedback
    bases = bases_of(result)
    assert len({tuple(base.position.tolist()) for base in bases}) == 1
    headings = [base.heading for base in bases]
    assert max(headings) - min(headings) < 0.02  # by noise of what is seen


@pytest.mark.parametrize(("aside", "places"), [(0.10, 1), (0.17, 2)])
def test_the_place_to_stand_at_moves_with_a_target_that_moves_by_more_than_noise(
    rig: Rig, aside: float, places: int
) -> None:
    rig.at(0.1, lambda: rig.see("target", (1.5, aside, 0.9)))
    bases = bases_of(rig.run("approach", target=(1.5, 0.0, 0.9), distance=0.4, timeout=0.3))
    assert len({tuple(base.position.tolist()) for base in bases}) == places


def test_faces_the_target_from_where_it_stands_once_it_stood_at_its_place(
    rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    ahead, side = np.array([0.8, 0.6]), np.array([-0.6, 0.8])
    place, straight = 0.6 * ahead, math.atan2(0.6, 0.8)
    moments = [  # where it is beside its place [m], whether it stands, and how much to the side it is to face [m]
        (0.05, False, 0.0),
        (0.05, True, 0.05),
        (0.05, False, 0.05),
        (0.20, False, 0.0),
        (0.05, False, 0.0),
    ]
    seen = RobotHandle.state.fget
    assert seen is not None

    def state_of(robot: RobotHandle) -> Any:
        state = seen(robot)
        moment = int(10 * state.time + 1e-6) - 1
        if moment < 0:
            return state
        aside, stands, _ = moments[moment]
        return replace(state, stance=np.append(place + aside * side, 2.0), base_settled=stands, gait=Gait.STEP)

    monkeypatch.setattr(RobotHandle, "state", property(state_of))
    result = rig.run("approach", target=(*ahead, 0.9), distance=0.4, timeout=0.58)
    headings = {round(command.stamp, 2): command.targets["base"].heading for command in result.commands[:-1]}
    for number, (_, _, faces) in enumerate(moments, 1):
        assert headings[round(0.1 * number + 0.04, 2)] == pytest.approx(straight - math.atan2(faces, 0.4), abs=0.01)
