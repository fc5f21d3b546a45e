"""The skill ``reach``, alone on the simulated robot."""

from typing import Literal

import numpy as np
import pytest

from humanoid_bt import Gait, Rig, Side


@pytest.mark.parametrize(
    ("target", "side"),
    [
        pytest.param((0.40, 0.15, 0.95), "left", marks=pytest.mark.trials),
        ((0.42, -0.10, 0.62), "right"),
        pytest.param((0.35, -0.25, 1.05), "right", marks=pytest.mark.trials),
    ],
)
def test_brings_the_nearest_palm_to_the_target_and_reports_how_near(
    rig: Rig, target: tuple[float, ...], side: Side
) -> None:
    result = rig.run("reach", target=target)
    assert result.succeeded, result.feedback
    assert rig.hand_distance(side, target) < 0.02
    assert result.results["hand_error"] == pytest.approx(rig.hand_distance(side, target), abs=0.01)
    assert result.results["hand_error"] < 0.015
    assert not result.stops


def test_a_robot_that_reaches_stands_at_rest(rig: Rig) -> None:
    rig.run("reach", target=(0.4, 0.3, 1.1), hand="left")
    result = rig.run("reach", target=(0.35, -0.2, 0.5), hand="right")
    assert result.succeeded
    assert max(np.hypot(*state.com_velocity[:2]) for state in result.states) > 0.018  # m/s: more than rest
    assert all(state.base_settled for state in result.states)


@pytest.mark.parametrize(
    ("axis", "column", "direction"),
    [pytest.param("fingers", 0, (1, 0, 0), marks=pytest.mark.trials), ("facing", 2, (0, 0, -2))],
)
def test_turns_the_hand_where_it_is_told(
    rig: Rig, axis: Literal["fingers", "facing"], column: int, direction: tuple[float, ...]
) -> None:
    target = (0.40, 0.15, 0.9)
    result = rig.run("reach", target=target, direction=direction, axis=axis, hold="1 s")
    assert result.succeeded, result.feedback
    assert rig.hand_distance("left", target) < 0.015
    pointed = rig.pose("left_palm").rotation[:, column]
    error = np.arccos(pointed @ direction / np.linalg.norm(direction))
    assert error < np.radians(3)
    assert rig.hand_turned("left", direction, axis) == pytest.approx(error, abs=1e-6)
    assert result.results["turn_error"] == pytest.approx(error, abs=0.01)


def test_says_what_keeps_it_from_turning_the_hand(rig: Rig) -> None:
    result = rig.run("reach", target=(0.40, 0.15, 0.9), direction=(-1, 0, 0))
    assert result.failed
    assert result.feedback.startswith("left hand turns no nearer than")
    assert "limit" in result.feedback
    assert rig.run("reach", target="target", direction=(0, 0, 0)).feedback == "the direction is zero: it points nowhere"


def test_moves_as_slowly_as_it_is_told(rig: Rig) -> None:
    result = rig.run("reach", target=(0.40, 0.15, 0.9), speed=0.1)
    assert result.succeeded, result.feedback
    palms = np.array([state.hands["left"] for state in result.states])
    assert np.linalg.norm(palms[5:] - palms[:-5], axis=1).max() / 0.1 < 0.13
    way = np.array([0.40, 0.15, 0.9]) - palms[0]
    length = np.linalg.norm(way)
    assert ((palms - palms[0]) @ way / length).max() < length + 0.006  # it does not go too far


@pytest.mark.trials
def test_uses_the_hand_it_is_told(rig: Rig) -> None:
    target = (0.40, 0.05, 0.9)
    result = rig.run("reach", target=target, hand="right")
    assert result.succeeded, result.feedback
    assert rig.hand_distance("right", target) < 0.02
    assert all("left_hand" not in command.targets for command in result.commands)


def test_follows_a_target_that_moves(rig: Rig) -> None:
    rig.at(1.0, lambda: rig.see("target", (0.40, 0.20, 0.85)))
    result = rig.run("reach", target=(0.40, 0.10, 1.0))
    assert result.succeeded, result.feedback
    assert rig.hand_distance("left", (0.40, 0.20, 0.85)) < 0.02


@pytest.mark.parametrize(
    "skill", ["reach", *(pytest.param(name, marks=pytest.mark.trials) for name in ("offer", "wave"))]
)
def test_says_that_something_touched_its_arm(rig: Rig, skill: str) -> None:
    rig.at(1.0, lambda: rig.push((-60.0, 0.0, 0.0), 0.2, "right_hand"))
    result = rig.run(skill, target=(0.40, -0.15, 0.95), hand="right")
    assert result.failed
    assert result.feedback.startswith("right arm touched something: ")
    assert not result.fell
    rig.settle(2.0)
    assert rig.run("reach", target=(0.40, -0.15, 0.95)).succeeded  # and can be asked anew


def test_says_how_near_it_came_when_the_target_is_out_of_reach(rig: Rig) -> None:
    result = rig.run("reach", target=(0.9, 0.2, 0.9), hand="left", timeout=12)
    assert result.failed
    assert "comes no nearer than" in result.feedback
    assert not result.fell


@pytest.mark.parametrize(
    "target",
    [
        (0.6, -0.4, 0.1),
        *(
            pytest.param(target, marks=pytest.mark.trials)
            for target in [(0.7, 0.0, 0.9), (0.65, -0.2, 0.7), (0.7, 0.3, 1.1), (0.65, 0.3, 1.1), (1.0, 0.0, 1.1)]
        ),
    ],
)
def test_leans_and_crouches_for_a_far_target_without_losing_its_balance(rig: Rig, target: tuple[float, ...]) -> None:
    result = rig.run("reach", target=target, timeout=12, patience=1.0)
    assert result.succeeded or "comes no nearer than" in result.feedback
    assert not result.stops
    assert all(state.gait is Gait.STAND for state in result.states)  # nor does it have to catch itself
    fastest = max(np.abs(state.setpoint_velocities).max() for state in result.states)
    assert fastest < 5.0  # a stretched arm does not chatter


def test_takes_the_hand_back_and_stands_when_halted(rig: Rig) -> None:
    rest = rig.state.hands["left"].copy()
    rig.run("reach", target=(0.40, 0.20, 0.95), timeout=1.2)
    assert np.linalg.norm(rig.state.hands["left"] - rest) > 0.15
    settled = rig.settle(2.5)
    assert settled.base_settled
    assert np.linalg.norm(settled.hands["left"] - rest) < 0.03


def test_waits_for_a_steady_base(rig: Rig) -> None:
    rig.run("approach", target=(2.0, 0.0, 0.9), timeout=0.8)
    rig.see("thing", (0.8, 0.1, 0.9))
    result = rig.run("reach", target="thing", timeout=0.3)
    assert result.feedback == "waiting for a steady base"
    assert not any("left_hand" in c.targets or "right_hand" in c.targets for c in result.commands)


@pytest.mark.trials
def test_survives_an_emergency_stop_with_the_arm_out(rig: Rig) -> None:
    rig.at(1.0, rig.raise_estop)
    rig.run("reach", target=(0.40, 0.20, 0.95), timeout=1.5)
    before = rig.state.hands["left"].copy()
    settled = rig.settle(1.5)
    assert settled.mode.value == "emergency_stop"
    assert np.linalg.norm(settled.hands["left"] - before) < 0.02


@pytest.mark.trials
@pytest.mark.parametrize(
    "target", [pytest.param((0.95, 0.1, 0.9), marks=pytest.mark.trials), (0.6, 0.2, 0.1)], ids=["far", "low"]
)
def test_stands_up_from_a_failed_reach_and_reaches_again(rig: Rig, target: tuple[float, float, float]) -> None:
    assert not rig.run("reach", target=target, timeout=12).succeeded
    assert rig.settle(3).base_settled
    again = rig.run("reach", target=(0.4, 0.1, 0.9))
    assert again.succeeded, again.feedback
    assert not again.stops


def test_reports_nothing_before_it_has_begun_to_move(rig: Rig) -> None:
    result = rig.run("reach", target=(0.40, 0.15, 0.95), timeout=0.1)
    assert result.feedback == "waiting for a steady base"
    assert result.results == {}


@pytest.mark.parametrize("target", [(0.55, 0.1, 0.75), pytest.param((0.6, -0.25, 0.8), marks=pytest.mark.trials)])
def test_goes_up_before_a_table_and_over_it(rig: Rig, target: tuple[float, float, float]) -> None:
    rig.see("table", (0.7, 0.0, 0.35), size=(0.6, 1.4, 0.7))
    result = rig.run("reach", target=target)
    assert result.succeeded, result.feedback
    side: Side = "left" if target[1] > 0 else "right"
    palms = np.array([state.hands[side] for state in result.states])
    beside, above = palms[palms[:, 0] > 0.3], palms[palms[:, 0] > 0.4]
    assert beside[:, 2].min() > 0.7
    assert above[0, 2] > 0.76
    assert palms[0, 2] < 0.6


def test_a_hand_that_is_below_a_table_comes_back_first(rig: Rig) -> None:
    assert rig.run("reach", target=(0.4, 0.2, 0.55), hold=0).succeeded
    rig.see("table", (0.7, 0.0, 0.68), size=(0.6, 1.4, 0.04))
    result = rig.run("reach", target=(0.55, 0.15, 0.78), patience=4)
    assert result.succeeded, result.feedback
    through = [state.hands["left"] for state in result.states if 0.6 < state.hands["left"][2] < 0.72]
    assert max(palm[0] for palm in through) < 0.38


def test_says_what_it_cannot_reach_over(rig: Rig) -> None:
    rig.see("wall", (0.45, 0.0, 1.0), size=(0.1, 3.0, 2.0))
    result = rig.run("reach", target=(0.65, 0.1, 0.9))
    assert result.failed
    assert result.feedback.startswith("left hand comes no nearer than ")
    assert result.feedback.endswith(": wall is in the way")
    assert max(state.hands["left"][0] for state in result.states) < 0.35


@pytest.mark.trials
def test_the_other_hand_tries_where_the_nearest_one_does_not_get_there(rig: Rig) -> None:
    result = rig.run("reach", target=(0.40, 0.04, 0.95), direction=(0, 1, -1), timeout=20)
    assert result.succeeded, result.feedback
    assert result.feedback.startswith("right hand ")
    hands = [name for command in result.commands for name in command.targets if name.endswith("hand")]
    assert list(dict.fromkeys(hands)) == ["left_hand", "right_hand"]


@pytest.mark.parametrize(("aside", "tried"), [(0.1, ["left", "right"]), (0.6, ["left"])])
def test_says_of_every_hand_that_tried_how_near_it_came(rig: Rig, aside: float, tried: list[str]) -> None:
    result = rig.run("reach", target=(0.9, aside, 0.9), timeout=25)
    assert result.failed
    told = result.feedback.split("; ")
    assert [line.split()[0] for line in told] == tried
    assert all("comes no nearer than" in line for line in told)


def test_the_other_hand_stays_where_it_is_when_something_touches_the_arm(rig: Rig) -> None:
    rig.at(1.0, lambda: rig.push((-60.0, 0.0, 0.0), 0.2, "right_hand"))
    result = rig.run("reach", target=(0.40, -0.1, 0.95))
    assert result.failed
    assert result.feedback.startswith("right arm touched something: ")
    assert {name for command in result.commands for name in command.targets if "hand" in name} == {"right_hand"}
