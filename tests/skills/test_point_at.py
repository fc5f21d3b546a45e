"""The skill ``point_at``, alone on the simulated robot."""

from __future__ import annotations

import importlib.util
import math
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from humanoid_bt import Rig, Side

CLOSE = math.radians(3)
SKILLS = Path(__file__).parents[2] / "skills"


def off(rig: Rig, side: Side, target: tuple[float, float, float]) -> float:
    """Return the angle from a hand's fingers to the line from its palm to the target [rad]."""
    palm = rig.pose(f"{side}_palm")
    return angle(palm.rotation[:, 0], np.array(target) - palm.position)


def angle(one: np.ndarray, other: np.ndarray) -> float:
    """Return the angle between two ways, shape (3,) each [rad]."""
    return math.acos(min(1.0, one @ other / np.linalg.norm(one) / np.linalg.norm(other)))


@pytest.mark.parametrize(
    ("target", "side"),
    [
        ((1.2, 0.4, 0.9), "left"),
        pytest.param((2.0, -0.8, 0.2), "right", marks=pytest.mark.trials),
        pytest.param((0.8, -0.1, 1.7), "right", marks=pytest.mark.trials),
    ],
)
def test_points_along_the_line_from_the_shoulder(rig: Rig, target: tuple[float, float, float], side: Side) -> None:
    result = rig.run("point_at", target=target)
    assert result.succeeded, result.feedback
    assert result.feedback.startswith(f"{side} hand points at target")
    assert off(rig, side, target) < CLOSE
    assert result.results["angle_error"] == pytest.approx(off(rig, side, target), abs=0.01)
    shoulder = rig.pose(f"{side}_shoulder").position
    assert angle(rig.pose(f"{side}_palm").rotation[:, 0], np.array(target) - shoulder) < 2 * CLOSE
    assert np.linalg.norm(rig.state.hands[side] - shoulder) > 0.45  # the arm is stretched
    assert not result.stops


@pytest.mark.parametrize(
    ("target", "side"),
    [
        ((-1.0, 0.3, 1.0), "left"),
        pytest.param((0.45, 0.2, 1.0), "left", marks=pytest.mark.trials, id="near"),
        pytest.param((-1.0, -0.3, 1.0), "right", marks=pytest.mark.trials),
    ],
)
def test_its_fingers_are_on_the_line_to_what_is_behind_it_or_near(
    rig: Rig, target: tuple[float, float, float], side: Side
) -> None:
    result = rig.run("point_at", target=target)
    assert result.succeeded, result.feedback
    assert off(rig, side, target) < CLOSE
    assert result.results["angle_error"] == pytest.approx(off(rig, side, target), abs=0.03)  # it sees it with noise


@pytest.mark.trials
@pytest.mark.parametrize("seed", range(50))
def test_points_at_what_is_anywhere_in_front_of_it(rig: Rig, seed: int) -> None:
    numbers = np.random.default_rng(seed)
    bearing, distance = numbers.uniform(-1, 1), numbers.uniform(0.6, 2.5)
    target = (distance * math.cos(bearing), distance * math.sin(bearing), numbers.uniform(0.1, 1.8))
    result = rig.run("point_at", target=target)
    assert result.succeeded, result.feedback
    assert off(rig, "left" if bearing > 0 else "right", target) < CLOSE
    assert not result.stops


def test_points_along_the_line_from_the_shoulder_wherever_it_stands(rig: Rig) -> None:
    assert rig.run("walk_to", x=0.5, y=0.3, heading=1.0, timeout=20).succeeded
    target = np.array([0.5, 0.3, 1.0]) + 1.5 * np.array([math.cos(1.2), math.sin(1.2), 0.0])
    result = rig.run("point_at", target=tuple(target.tolist()))
    assert result.succeeded, result.feedback
    line, fingers = target - rig.pose("left_shoulder").position, rig.pose("left_palm").rotation[:, 0]
    assert line @ fingers / np.linalg.norm(line) > math.cos(math.radians(6))


def test_follows_a_target_that_moves(rig: Rig) -> None:
    rig.at(1.5, lambda: rig.see("target", (1.2, 0.2, 1.3)))
    result = rig.run("point_at", target=(1.2, 0.5, 0.7), hold="2 s")
    assert result.succeeded, result.feedback
    assert off(rig, "left", (1.2, 0.2, 1.3)) < CLOSE


def test_stays_clear_of_the_side_of_something_solid(rig: Rig) -> None:
    rig.see("wall", (0.9, 0.1, 0.8), size=(0.8, 1.8, 1.6))
    result = rig.run("point_at", target="wall", hold="0.1 s")
    assert result.succeeded, result.feedback
    assert off(rig, "left", (0.9, 0.1, 0.8)) < CLOSE
    assert max(state.hands["left"][0] for state in result.states) < 0.45, "its side is at 0.5"


@pytest.mark.parametrize(("heading", "half"), [(0.7, 0.5), (0.7 - math.pi / 2, 0.05)])
def test_a_thing_reaches_as_far_as_it_is_turned(heading: float, half: float) -> None:
    spec = importlib.util.spec_from_file_location("point_at_alone", SKILLS / "point_at.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    thing = SimpleNamespace(size=np.array([1.0, 0.1, 2.0]), heading_world=heading)
    assert module._half(thing, np.array([math.cos(0.7), math.sin(0.7), 0.0])) == pytest.approx(half)


def test_gives_up_at_once_when_something_touches_its_arm(rig: Rig) -> None:
    rig.at(1.0, lambda: rig.push((-60.0, 0.0, 0.0), 0.2, "right_hand"))
    result = rig.run("point_at", target=(2.0, -0.5, 0.9), hand="right", hold="3 s")
    assert result.failed
    assert result.feedback.startswith("right arm touched something: ")
    assert result.states[-1].time < 1.5


@pytest.mark.parametrize(("target", "size"), [((0.3, 0.2, 0.9), None), ((1.1, 0.2, 0.9), (1.6, 1.6, 1.6))])
def test_says_that_something_is_too_near(
    rig: Rig, target: tuple[float, float, float], size: tuple[float, float, float] | None
) -> None:
    rig.see("target", target, size=size)
    result = rig.run("point_at", target="target")
    assert result.failed
    assert re.match("target is too near to point at: [34]", result.feedback), result.feedback


@pytest.mark.trials
@pytest.mark.parametrize(
    ("target", "why"),
    [
        ((-0.18, 0.38, 1.51), "right hand comes no nearer than .* cm: the torso is in the way"),
        ((-0.07, 0.41, 0.7), "right hand turns no nearer than . deg: the torso is in the way"),
    ],
)
def test_says_what_keeps_it_from_pointing(rig: Rig, target: tuple[float, float, float], why: str) -> None:
    result = rig.run("point_at", target=target, hand="right", look=False, timeout=15)
    assert result.failed
    assert re.fullmatch(why, result.feedback)
    assert not result.stops


def test_says_that_it_never_saw_it(rig: Rig) -> None:
    assert rig.run("point_at", target="cup").feedback.startswith("'cup' was never seen")
