"""Velocity commands that bring a walker to a place: on a point that moves as it is told."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.control.body.planar import ahead, seen_from, wrap
from humanoid_bt.control.body.policy.velocity import ARRIVED, LEAVES, VelocityReference
from humanoid_bt.core.messages import Array, Gait
from humanoid_bt.robot.policy.policy import load_policy
from tests.policy_files import write_walker

pytest.importorskip("onnxruntime", reason="learned walkers need onnxruntime: pip install 'humanoid-bt[policy]'")

DT = 0.02


@pytest.fixture
def velocity(tmp_path: Path) -> VelocityReference:
    return VelocityReference(load_policy(write_walker(tmp_path)), DT)


def walk(velocity: VelocityReference, goal: Array, seconds: float, obeys: float = 0.8, lag: float = 0.0) -> Array:
    """Return where a point is after a time that does a share of what it is told, less a lag backward [m/s]."""
    stance = np.zeros(3)
    for _ in range(round(seconds / DT)):
        vx, vy, wz = velocity.update(goal, stance).tolist()
        assert abs(vx) <= 1 and abs(vy) <= 0.5 and abs(wz) <= 1, "beyond what the policy can be commanded"
        back = 0.0 if velocity.stands else lag
        stance = ahead(stance, DT * (obeys * vx - back), DT * obeys * vy, DT * obeys * wz)
    return stance


@pytest.mark.parametrize("bearing", np.arange(-3, 3.1, 1.0))
@pytest.mark.parametrize("heading", [-2.0, 0.0, 3.0])
def test_arrives_and_stands(velocity: VelocityReference, bearing: float, heading: float) -> None:
    goal = np.array([2 * math.cos(bearing), 2 * math.sin(bearing), heading])
    stance = walk(velocity, goal, 20)
    assert math.dist(stance[:2], goal[:2]) < LEAVES[0]
    assert abs(wrap(stance[2] - heading)) < LEAVES[1]
    assert velocity.stands


def test_insists_where_the_walker_lags_behind(velocity: VelocityReference) -> None:
    goal = np.array([0.4, 0.0, 0.0])
    stance = walk(velocity, goal, 20, lag=0.15)
    assert math.dist(stance[:2], goal[:2]) < LEAVES[0]


def test_without_a_goal_it_stands_at_once(velocity: VelocityReference) -> None:
    walk(velocity, np.array([2.0, 0.0, 0.0]), 1)
    assert not velocity.stands
    velocity.update(None, np.zeros(3))
    assert velocity.stands


def test_starts_again_only_beyond_the_farther_bound(velocity: VelocityReference) -> None:
    between = (ARRIVED[0] + LEAVES[0]) / 2
    velocity.update(np.array([between, 0.0, 0.0]), np.zeros(3))
    assert velocity.stands
    velocity.update(np.array([LEAVES[0] + 0.01, 0.0, 0.0]), np.zeros(3))
    assert not velocity.stands
    velocity.update(np.array([between, 0.0, 0.0]), np.zeros(3))
    assert not velocity.stands, "it goes all the way once it goes"


def test_gait_tells_what_the_legs_do(velocity: VelocityReference) -> None:
    velocity.update(np.array([1.0, 0.0, 0.0]), np.zeros(3))
    velocity.note(0.3, 0.005)
    assert velocity.gait is Gait.STEP
    velocity.update(None, np.zeros(3))
    velocity.note(0.3, 0.005)
    assert velocity.gait is Gait.SETTLE
    for _ in range(60):
        velocity.note(0.01, 0.005)
    assert velocity.gait is Gait.STAND
    velocity.note(0.3, 0.005)
    assert velocity.gait is Gait.SETTLE, "it was pushed"


def stop(
    velocity: VelocityReference, goal: Array, stance: Array, rests: Callable[[Array], Array], sways: float = 0.0
) -> tuple[Array, int]:
    """Return where a point is at rest, and how often it stopped; ``rests`` is where it ends that stops somewhere."""
    stops = 0
    for _ in range(round(20 / DT)):
        stood = velocity.stands
        vx, vy, wz = velocity.update(goal, stance, 0.0 if velocity.stands else sways).tolist()
        stance = ahead(stance, DT * vx, DT * vy, DT * wz)
        if velocity.stands and not stood:
            stops, stance = stops + 1, rests(stance)
        for _ in range(4):
            velocity.note(0.0 if velocity.stands else 0.3, DT / 4)
    assert velocity.gait is Gait.STAND
    return stance, stops


def test_one_that_slides_as_it_stops_goes_there_once_more_and_learns(velocity: VelocityReference) -> None:
    slides = np.array([-0.035, 0.0, 0.02])
    stance, counts, off = np.zeros(3), [], []
    for _ in range(6):
        goal = ahead(stance, 1.0, 0.0, 0.0)
        stance, stops = stop(velocity, goal, stance, lambda there: ahead(there, *slides.tolist()))
        counts.append(stops)
        off.append(np.abs(seen_from(goal, stance)).max())
    assert 1 < counts[0] <= 5
    assert counts[3:] == [1, 1, 1]
    assert off[0] < LEAVES[0]
    assert max(off[3:]) < ARRIVED[0] + 0.005


def test_one_that_cannot_stop_nearer_goes_there_twice_more_only(velocity: VelocityReference) -> None:
    goal = np.array([1.0, 0.0, 0.0])
    _, stops = stop(velocity, goal, np.zeros(3), lambda _: ahead(goal, 0.032, 0.0, 0.0))
    assert stops == 3


def test_one_that_sways_far_stops_where_it_is_sent_all_the_same(velocity: VelocityReference) -> None:
    goal = np.array([1.0, 0.0, 0.0])
    stance, stops = stop(velocity, goal, np.zeros(3), lambda there: there, sways=1.0)
    assert abs(seen_from(goal, stance)).max() < LEAVES[0]
    assert stops <= 3


def test_one_that_does_not_turn_slowly_turns_all_the_same(velocity: VelocityReference) -> None:
    goal, stance = np.array([0.0, 0.0, 0.1]), np.zeros(3)
    for _ in range(round(6 / DT)):
        wz = velocity.update(goal, stance).item(2)
        if abs(wz) > 0.2:  # rad/s
            stance = ahead(stance, 0.0, 0.0, DT * wz)
    assert abs(goal[2] - stance[2]) < ARRIVED[1]


def test_it_does_not_insist_on_a_turn_that_has_only_begun(velocity: VelocityReference) -> None:
    goal = np.array([0.0, 0.0, 0.3])
    rates = [velocity.update(goal, np.zeros(3)).item(2) for _ in range(round(2 / DT))]
    assert 0.1 < rates[-1] < 0.9
    assert rates[len(rates) // 2] == rates[-1]


@pytest.mark.parametrize("stops", [True, False])
def test_it_does_not_insist_on_a_place_to_which_it_is_not_sent_any_more(
    velocity: VelocityReference, stops: bool
) -> None:
    stance = walk(velocity, np.array([0.4, 0.0, 0.0]), 1.5, obeys=0.2)
    if stops:
        velocity.update(None, stance)
    behind = ahead(stance, -0.2, 0.0, 0.0)
    commands = [velocity.update(behind, stance).item(0) for _ in range(round(0.6 / DT))]
    assert commands[-1] < -0.2
    assert all(later <= sooner for sooner, later in pairwise(commands))
