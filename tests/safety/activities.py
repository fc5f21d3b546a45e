"""What the robot does when a fault comes: standing, or walking."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from humanoid_bt.control.body.planar import ahead
from humanoid_bt.core.messages import Array, BaseTarget, HandTarget, State
from tests.safety.machine import Targets


@dataclass(frozen=True)
class Plan:
    """One activity with its random numbers drawn.

    Attributes:
        targets: what decision wants.
        ball: where the tree's target is seen, world frame [m]; seen doubtfully when the robot shall stand still.
        confidence: with which it is seen.
        earliest, latest: between them is the moment of the fault [s].
    """

    targets: Callable[[State], Targets]
    ball: Array
    confidence: float
    earliest: float
    latest: float


def still(rng: np.random.Generator) -> Plan:
    return Plan(lambda _: {}, np.array([0.4, 0.0, 0.8]), 0.3, 0.2, 0.8)


def reaching(rng: np.random.Generator) -> Plan:
    side, sign = _side(rng)
    ball = np.array([rng.uniform(0.28, 0.42), sign * rng.uniform(0.0, 0.12), rng.uniform(0.6, 1.1)])
    targets = {f"{side}_hand": HandTarget(ball)}
    return Plan(lambda _: targets, ball, 0.95, 0.2, 1.6)


def straight(rng: np.random.Generator) -> Plan:
    goal = np.array([rng.uniform(2.5, 3.5), rng.uniform(-0.8, 0.8)])
    return Plan(_base(*goal, 0.0), np.array([*goal, 0.9]), 0.95, 0.9, 3.0)


def turning(rng: np.random.Generator) -> Plan:
    _, sign = _side(rng)
    ball = np.array([-2.0, sign * rng.uniform(0.2, 1.0), 0.9])
    return Plan(_base(0.0, 0.0, sign * rng.uniform(2.0, 3.1)), ball, 0.95, 0.9, 3.0)


def side_stepping(rng: np.random.Generator) -> Plan:
    _, sign = _side(rng)
    return Plan(_base(0.0, sign * 0.34, 0.0), np.array([0.55, sign * 0.45, 0.9]), 0.95, 0.9, 2.4)


def backward(rng: np.random.Generator) -> Plan:
    ball = np.array([0.1, rng.uniform(-0.05, 0.05), 0.9])
    return Plan(_base(-0.33, rng.uniform(-0.1, 0.1), 0.0), ball, 0.95, 0.9, 2.0)


def carrying(rng: np.random.Generator) -> Plan:
    """Walk with a hand held out in front."""
    side, sign = _side(rng)
    base = BaseTarget(np.array([3.0, 0.0]), 0.0)
    forward, height = rng.uniform(0.25, 0.35), rng.uniform(0.75, 1.0)

    def targets(state: State) -> Targets:
        palm = ahead(state.stance, forward, 0.2 * sign)
        return {"base": base, f"{side}_hand": HandTarget(np.array([*palm[:2], height]))}

    return Plan(targets, np.array([3.0, 0.0, 0.9]), 0.95, 0.9, 3.0)


def leaving(rng: np.random.Generator) -> Plan:
    """Walk on although the hand is still sent to a place that falls behind."""
    side, sign = _side(rng)
    base = BaseTarget(np.array([3.0, 0.0]), 0.0)
    palm = HandTarget(np.array([rng.uniform(0.3, 0.5), 0.2 * sign, rng.uniform(0.7, 1.0)]))
    return Plan(lambda _: {"base": base, f"{side}_hand": palm}, np.array([3.0, 0.0, 0.9]), 0.95, 0.9, 4.0)


STANDING = {"standing still": still, "reaching": reaching}
WALKING = {
    "walking straight": straight,
    "turning": turning,
    "side-stepping": side_stepping,
    "stepping back": backward,
    "walking with a hand out": carrying,
    "walking away from a hand's target": leaving,
}
ACTIVITIES = {**STANDING, **WALKING}


def _side(rng: np.random.Generator) -> tuple[str, int]:
    return ("left", 1) if rng.random() < 0.5 else ("right", -1)


def _base(x: float, y: float, heading: float) -> Callable[[State], Targets]:
    assert math.isfinite(x + y + heading)
    targets = {"base": BaseTarget(np.array([x, y]), heading)}
    return lambda _: targets
