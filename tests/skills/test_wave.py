"""The skill ``wave``, alone on the simulated robot."""

from collections.abc import Callable

import numpy as np
import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt import Gait, Rig, RigResult, Side


def turns(result: RigResult, side: Side) -> int:
    """Return how often the raised palm turned round on its way from side to side."""
    raised = [s.hands[side] for s in result.states if s.hands[side][2] > s.gaze_position[2] - 0.1]
    moves = np.diff([palm[1] for palm in raised])
    signs = np.sign(moves[np.abs(moves) > 0.001])
    return int(np.count_nonzero(np.diff(signs)))


@pytest.mark.parametrize("hand", ["left", pytest.param("right", marks=pytest.mark.trials)])
def test_waves_beside_the_head_as_often_as_it_is_told(rig: Rig, hand: Side) -> None:
    result = rig.run("wave", hand=hand, times=2)
    assert result.succeeded, result.feedback
    assert turns(result, hand) in (3, 4)  # the first stroke may go on from the way up
    x, y, z = rig.state.hands[hand]
    assert 0.1 < x < 0.3
    assert 0.15 < (y if hand == "left" else -y) < 0.45
    assert z == pytest.approx(rig.state.gaze_position[2], abs=0.08)
    other = "right_hand" if hand == "left" else "left_hand"
    assert all(other not in command.targets for command in result.commands)
    assert all(state.gait is Gait.STAND for state in result.states)
    assert not result.stops


@pytest.mark.parametrize(("y", "side"), [(0.5, "left"), (-0.5, "right")])
def test_takes_the_hand_on_the_targets_side(rig: Rig, y: float, side: Side) -> None:
    result = rig.run("wave", target=(1.5, y, 1.2), timeout=0.5)
    assert f"{side}_hand" in result.commands[-1].targets


def test_takes_the_right_hand_when_there_is_no_target(rig: Rig) -> None:
    result = rig.run("wave", timeout=0.5)
    assert result.feedback == "raising the right hand"


def test_waits_for_a_steady_base(rig: Rig) -> None:
    rig.run("walk_to", x=1.0, y=0.0, timeout=0.8)
    result = rig.run("wave", timeout=0.3)
    assert result.feedback == "waiting for a steady base"
    assert not any(command.targets for command in result.commands)


@pytest.mark.trials
def test_takes_the_hand_back_when_halted_and_begins_anew(rig: Rig) -> None:
    rest = rig.state.hands["left"].copy()
    rig.run("wave", hand="left", timeout=2.0)
    assert rig.state.hands["left"][2] > 1.0
    assert np.linalg.norm(rig.settle(2.5).hands["left"] - rest) < 0.03
    result = rig.run("wave", hand="left", times=1)
    assert result.succeeded, result.feedback
    assert turns(result, "left") >= 1


def test_does_not_count_waves_that_an_emergency_stop_prevents(rig: Rig) -> None:
    rig.at(2.0, rig.raise_estop)
    result = rig.run("wave", hand="right", patience=1.0)
    assert result.failed
    assert "right hand comes no nearer" in result.feedback
    assert not result.fell


def test_has_new_patience_for_every_stroke(rig: Rig) -> None:
    result = rig.run("wave", times=8, timeout=15)
    assert result.succeeded, result.feedback


def test_gives_up_at_once_when_something_touches_the_arm(rig: Rig) -> None:
    rig.at(0.5, lambda: rig.push((-60, 0, 0), duration=0.6, body="right_forearm"))
    result = rig.run("wave", hand="right", patience=5.0)
    assert result.failed
    assert result.feedback.startswith("right arm touched something")
    assert result.time < 1.2


def test_a_wave_that_is_told_to_wave_less_often_than_it_has_ends(session_of: Callable[[str], hbt.Session]) -> None:
    with session_of("wave: {times: 9}") as session:
        session.run_until(lambda s: s.node("wave").results.get("waved") == 2, timeout=8)
        session.set("wave.times", 1)
        session.run_until(session.time + 0.5)
        assert session.node("wave").status is Status.SUCCESS
        assert session.node("wave").feedback == "waved the right hand 2 times"
