"""Velocity commands that bring a walker to a place: on a point that moves as it is told."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.control.body.planar import ahead, wrap
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
