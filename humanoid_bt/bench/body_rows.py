"""What a robot's body is tried with: rows of a table, and the trial that a seed makes of one."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from humanoid_bt.bench.promises import BODY as USUAL
from humanoid_bt.bench.promises import HARD_PUSH, Promise
from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.trial import CONDITION, PUSH, SET, Trial
from humanoid_bt.core.units import readable
from humanoid_bt.plant.scene import random_stream
from humanoid_bt.robot.config import Walk

BODY = "body"
"""In what a trial is given: which body it tries."""

STAND = "stand"
"""The tree of a robot that stands, which goes on for ever."""

_WALK, _FETCH = str(Path(__file__).with_name("walk.yaml")), "fetch"
_EMPTY, _BALL = "empty", "random_target"
_WALKING_TIME, _STANDING_TIME, _FETCHING_TIME = 60.0, 6.0, 120.0  # s
_PUSH_TIME = 0.1  # s
_PUSHED_AT = (0.6, 1.6)  # s: half a meter straight ahead takes longer
_DISTANCE = (0.5, 3.0)  # m
_AROUND = (-math.pi, math.pi)  # rad
_AHEAD = (0.0, 0.0)  # rad
_OFF = math.radians(0.5)


@dataclass(frozen=True)
class Row:
    """Something that a body is to withstand.

    Attributes:
        name: the row's.
        what: the same in words.
        promise: of which share of the trials it withstands it [%].
        walks: whether it has a random goal, which it is to reach; else it stands, and is to stay on its feet.
        push: a push from a random side [N], 0 for none.
        conditions: what is different from the robot's numbers.
        drawn: conditions that the seed says, each with what draws it.
        hands: whether it takes hands.
        fetches: whether the goal is to touch a ball, by the tree ``fetch``; else it is a place.
        goals: between which numbers the goal is drawn: distance [m], bearing and heading [rad].
        limits: what of a trial may be at most how much, in SI units: "drift" and the like.
    """

    name: str
    what: str
    promise: Promise = USUAL
    walks: bool = True
    push: float = 0.0
    conditions: Mapping[str, float] = field(default_factory=dict)
    drawn: Mapping[str, Callable[[np.random.Generator], float]] = field(default_factory=dict)
    hands: bool = False
    fetches: bool = False
    goals: tuple[tuple[float, float], tuple[float, float], tuple[float, float]] = (_DISTANCE, _AROUND, _AROUND)
    limits: Mapping[str, float] = field(default_factory=dict)

    def trial(self, number: int, robot: str, seed: int, body: Walk | None = None) -> Trial:
        """Return a trial of this row.

        Rows with the same ``goals`` draw the same goal, moment and direction of a seed, for every body.

        Args:
            number: its place among all trials.
            robot: the ``robot.yaml``.
            seed: of everything random.
            body: what walks and balances; what ``robot.yaml`` says if None.
        """
        numbers = random_stream(seed, "bench", "body")
        ends = (*self.goals, _PUSHED_AT, _AROUND)
        distance, bearing, heading, at, side = (float(numbers.uniform(*pair)) for pair in ends)
        goal = {"x": distance * math.cos(bearing), "y": distance * math.sin(bearing), "heading": heading}
        push = {"at": at, "force": self.push, "direction": side, "duration": _PUSH_TIME}
        drawn = {name: float(draw(numbers)) for name, draw in self.drawn.items()}
        given: dict[str, Any] = {f"{CONDITION}.{name}": value for name, value in {**self.conditions, **drawn}.items()}
        given |= {f"{PUSH}.1.{name}": value for name, value in push.items()} if self.push else {}
        if body:
            given[BODY] = body
        if self.fetches:
            return Trial(number, _FETCH, robot, _BALL, seed, given, _FETCHING_TIME)
        if not self.walks:
            return Trial(number, STAND, robot, _EMPTY, seed, given, _STANDING_TIME)
        given |= {f"{SET}.{name}": value for name, value in goal.items()}
        return Trial(number, _WALK, robot, _EMPTY, seed, given, _WALKING_TIME)

    def judged(self, result: Result) -> Result:
        """Return what came of a trial: no success if something was more than it may be."""
        for name, most in self.limits.items():
            if result.succeeded and (value := float(result.values[name])) > most:
                unit = result.units.get(name, "")
                reason = f"{name.replace('_', ' ')} {readable(value, unit)}, at most {readable(most, unit)}"
                return replace(result, outcome="failure", reason=reason)
        return result


def _around(numbers: np.random.Generator) -> float:
    return numbers.uniform(*_AROUND)


def _off(numbers: np.random.Generator) -> float:
    return float(numbers.choice((-_OFF, _OFF)))


def _pushed(walks: bool, *forces: float) -> list[Row]:
    how = "walking" if walks else "standing"
    return [
        Row(
            f"push-{how}-{force:g}",
            f"pushed with {force:g} N for {_PUSH_TIME:g} s, {how}",
            HARD_PUSH if force >= 200 and not walks else USUAL,
            walks,
            force,
        )
        for force in forces
    ]


ROWS = (
    Row("goals", "walks to a random goal"),
    Row("straight", "walks 3 m straight ahead", goals=((3.0, 3.0), _AHEAD, _AHEAD)),
    Row("metre", "walks 1 m in any direction, with any heading at the end", goals=((1.0, 1.0), _AROUND, _AROUND)),
    Row(
        "odometry",
        "5 m to a random goal: off by 1.5 % of it, 1.5 deg, 3 cm/s",
        goals=((5.0, 5.0), _AROUND, _AROUND),
        limits={"drift": 0.015, "heading_error": math.radians(1.5), "velocity_error": 0.03},
    ),
    *_pushed(True, 60, 100, 150, 200),
    *_pushed(False, 60, 100, 130, 150, 200),
    *(Row(f"friction-{value:g}", f"friction {value:g}", conditions={"friction": value}) for value in (0.6, 0.4, 0.3)),
    *(Row(f"torso-{mass:g}kg", f"{mass:g} kg on the torso", conditions={"payload": mass}) for mass in (2.0, 5.0)),
    Row("hands-2kg", "2 kg in each hand", conditions={"hand_payload": 2.0}, hands=True),
    Row("weak-drives", "drives give 0.7 of what they are asked for", conditions={"drives": 0.7}),
    Row("late-drives", "drives hear of commands 3 ms later", conditions={"drive_delay": 0.003}),
    Row("plates", "plates of 10 mm on the floor", conditions={"plates": 0.01}),
    Row("slope", "a slope of 4 deg", conditions={"slope": math.radians(4)}, drawn={"uphill": _around}),
    Row("encoder", "the encoder of a leg's joint 0.5 deg off", drawn={"encoder_error": _off}),
    Row("fetch", "walks to a ball 1 to 3 m away, in any direction, and touches it", hands=True, fetches=True),
)
"""All of them, in the order in which they are tried."""
