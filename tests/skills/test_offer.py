"""The skill ``offer``, alone on the simulated robot."""

import math

import numpy as np
import pytest

from humanoid_bt import Rig, RigResult, Side


def nearest(result: RigResult, target: tuple[float, ...]) -> float:
    """Return how near a palm ever came to a target that stands still, seen from above [m]."""
    away = [palm[:2] - target[:2] for state in result.states for palm in state.hands.values()]
    return float(np.linalg.norm(away, axis=1).min())


@pytest.mark.parametrize(
    ("bearing", "side"),
    [
        (60, "left"),
        pytest.param(10, "left", marks=pytest.mark.trials),
        pytest.param(-60, "right", marks=pytest.mark.trials),
    ],
)
def test_holds_the_nearest_palm_out_toward_the_target(rig: Rig, bearing: float, side: Side) -> None:
    angle = math.radians(bearing)
    target = (1.2 * math.cos(angle), 1.2 * math.sin(angle), 1.2)
    result = rig.run("offer", target=target, hold=0.5)
    assert result.succeeded, result.feedback
    palm = rig.state.hands[side]
    out = rig._model.config.reach_distance
    assert palm[:2] == pytest.approx([out * math.cos(angle), out * math.sin(angle)], abs=0.03)
    assert 0.7 < palm[2] < rig.state.gaze_position[2] - 0.2
    assert not result.stops


def test_holds_it_where_and_for_as_long_as_it_is_told(rig: Rig) -> None:
    result = rig.run("offer", target=(1.0, 0.2, 1.2), hand="right", distance=0.3, height=0.8, hold=1.0)
    assert result.succeeded, result.feedback
    there = [np.linalg.norm(s.hands["right"] - (0.294, 0.059, 0.8)) < 0.035 for s in result.states]
    assert sum(there) >= 50
    assert all(there[-50:])


@pytest.mark.parametrize("bearing", [0, *(pytest.param(bearing, marks=pytest.mark.trials) for bearing in (60, -90))])
def test_stays_clear_of_a_target_that_is_near(rig: Rig, bearing: float) -> None:
    angle = math.radians(bearing)
    target = (0.45 * math.cos(angle), 0.45 * math.sin(angle), 0.9)
    result = rig.run("offer", target=target, hold=0.5)
    assert result.succeeded, result.feedback
    assert nearest(result, target) > 0.17


@pytest.mark.trials
def test_draws_the_hand_back_from_a_target_that_comes_nearer(rig: Rig) -> None:
    for i in range(20):
        rig.at(2.0 + 0.1 * i, lambda i=i: rig.see("target", (0.8 - 0.02 * i, 0.0, 1.2)))
    result = rig.run("offer", target=(0.8, 0.0, 1.2), hold=3.0, timeout=4.5)
    out = [state.hands["right"][0] for state in result.states]
    assert max(out) > 0.37
    assert out[-1] < 0.25
    assert not result.failed


def test_draws_the_palm_back_at_once_from_a_target_that_comes_a_little_nearer(rig: Rig) -> None:
    rig.at(1.5, lambda: rig.see("target", (0.67, 0.0, 1.0)))
    result = rig.run("offer", target=(0.70, 0.0, 1.0), distance=0.6, clearance=0.2, hold=3.0, timeout=2.0)
    ahead = {
        round(command.stamp, 2): float(np.hypot(*command.targets["right_hand"].position[:2]))
        for command in result.commands
        if "right_hand" in command.targets
    }
    assert ahead[1.4] == pytest.approx(0.50, abs=0.01)
    assert ahead[1.66] == pytest.approx(0.47, abs=0.01)


def test_says_that_the_target_is_too_near(rig: Rig) -> None:
    result = rig.run("offer", target=(0.25, 0.0, 1.2))
    assert result.failed
    assert result.feedback == "target is too near: 0.25 m"


@pytest.mark.trials
def test_says_how_near_it_came_when_the_hand_does_not_get_there(rig: Rig) -> None:
    result = rig.run("offer", target=(2.0, 0.0, 1.2), distance=1.0, patience=0.5)
    assert result.failed
    assert "comes no nearer than" in result.feedback
    assert not result.fell


def test_waits_for_a_steady_base(rig: Rig) -> None:
    rig.run("walk_to", x=1.0, y=0.0, timeout=0.8)
    rig.see("person", (2.0, 0.0, 1.2))
    result = rig.run("offer", target="person", timeout=0.3)
    assert result.feedback == "waiting for a steady base"
    assert not any("left_hand" in c.targets or "right_hand" in c.targets for c in result.commands)


def test_gives_up_at_once_when_something_touches_the_arm(rig: Rig) -> None:
    rig.at(0.5, lambda: rig.push((-60, 0, 0), duration=0.6, body="right_forearm"))
    result = rig.run("offer", target=(1.2, -0.3, 1.0), hand="right", patience=5.0)
    assert result.failed
    assert result.feedback.startswith("right arm touched something")
    assert result.time < 1.2


@pytest.mark.trials
def test_takes_the_hand_back_when_halted(rig: Rig) -> None:
    rest = rig.state.hands["left"].copy()
    rig.run("offer", target=(1.0, 0.3, 1.2), timeout=1.2)
    assert np.linalg.norm(rig.state.hands["left"] - rest) > 0.15
    assert np.linalg.norm(rig.settle(2.5).hands["left"] - rest) < 0.03


def test_fails_when_the_target_was_never_seen(rig: Rig) -> None:
    result = rig.run("offer", target="nobody")
    assert result.failed
    assert "'nobody' was never seen: perception offers no such percept" in result.feedback


@pytest.mark.trials
def test_leaves_the_gaze_alone_when_it_is_not_to_look(rig: Rig) -> None:
    result = rig.run("offer", target=(1.0, 0.2, 1.2), hold=0.2, look=False)
    assert result.succeeded, result.feedback
    assert not any("gaze" in command.targets for command in result.commands)
    assert result.results["hand_error"] < 0.03
    assert result.results["target_distance"] == pytest.approx(1.02, abs=0.03)


def test_says_that_the_distance_is_too_near_to_hold_a_hand_out(rig: Rig) -> None:
    result = rig.run("offer", target=(1.0, 0.0, 1.0), distance=0.05)
    assert result.failed
    assert result.feedback == "0.05 m is too near to hold a palm out: it takes 0.10 m"
