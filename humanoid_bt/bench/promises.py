"""The numbers that the docs promise: their tables are made from these, and ``bench`` judges by them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Promise:
    """A bound that holds for something that is measured.

    Attributes:
        what: what is measured.
        bound: the largest value that keeps the promise, or the smallest.
        unit: of the bound; "x" for a ratio to a baseline.
        at_least: whether the bound is the smallest value.
        command: what measures it.
    """

    what: str
    bound: float
    unit: Literal["x", "us", "ms", "s", "m/s", "%"]
    at_least: bool = False
    command: str = "bench"

    @property
    def text(self) -> str:
        """The bound in words."""
        return f"{'>=' if self.at_least else '<='} {self.bound:g}{'' if self.unit == 'x' else ' '}{self.unit}"

    def verdict(self, value: float) -> Verdict:
        """Return whether a measured value keeps it."""
        return verdict(value >= self.bound if self.at_least else value <= self.bound)


Verdict = Literal["ok", "missed"]


def verdict(kept: bool) -> Verdict:
    """Return the word for a promise that was kept, or was not."""
    return "ok" if kept else "missed"


STACK = Promise("the whole stack, recording on, beside `mj_step` of the same motion", 3.5, "x")
SPEED = Promise("simulated time of a run, recording on, beside the CPU time it takes", 8.0, "x", at_least=True)
ESTIMATE = Promise("estimating the robot, beside `mj_step` for as long", 0.4, "x")
OWN_LINKS = Promise("keeping own links apart that are near each other, beside `mj_step` for as long", 0.2, "x")
LOG_USUAL = Promise("keeping a servo cycle for the recording, p50, beside `mj_step` for as long", 0.06, "x")
LOG = Promise("keeping a servo cycle for the recording, p99, beside `mj_step` for as long", 0.15, "x")
TICK = Promise("a tick, snapshot and command included, beside plain py_trees with the same leaves", 1.0, "x")
LOAD = Promise("loading a tree of 500 nodes with all checks, beside `yaml.safe_load` of its text", 2.0, "x")

_REALTIME = "bench --realtime"
LATENESS = Promise(
    "lateness of the servo, p99, idle and under load, with realtime priority", 100.0, "us", False, _REALTIME
)
E_STOP = Promise("from an e-stop to the emergency stop, p99", 3.0, "ms", False, _REALTIME)
PROTECTIVE_STOP = Promise(
    "from a decision that is silent or sends nonsense to the protective stop", 120.0, "ms", False, _REALTIME
)
RECORDED_TICK = Promise(
    "processor time that a recording adds to a tick of decision, p99, idle and under load",
    1.0,
    "ms",
    False,
    _REALTIME,
)

_SPEED = "bench --speed"
WALKER_SPEED = Promise(
    "simulated time of a learned walker that stands or walks, beside the CPU time it takes", 15.0, "x", True, _SPEED
)
ARMS = Promise("inverse kinematics of both arms of a learned walker, one solve", 300.0, "us", False, _SPEED)

_BODY = "bench --body"
BODY = Promise("random goals reached, or pushes withstood, under each of its conditions", 95.0, "%", True, _BODY)
HARD_PUSH = Promise("pushes of 200 N for 0.1 s withstood standing", 90.0, "%", True, _BODY)
PACE = Promise("speed of walking straight ahead", 0.5, "m/s", True, _BODY)
METRE = Promise("a walk of 1 m in any direction, with any heading at the end", 4.0, "s", False, _BODY)
FROM_COMMAND = Promise("from the command to walk until a foot is off the floor", 0.4, "s", False, _BODY)
FROM_TOUCHDOWN = Promise("from the last touchdown until the base is settled", 0.8, "s", False, _BODY)
GAIT = (PACE, METRE, FROM_COMMAND, FROM_TOUCHDOWN)

_WHOLE = (STACK, SPEED, ESTIMATE, OWN_LINKS, LOG_USUAL, LOG, TICK, LOAD)
PROMISES = (*_WHOLE, LATENESS, E_STOP, PROTECTIVE_STOP, RECORDED_TICK, WALKER_SPEED, ARMS, BODY, HARD_PUSH, *GAIT)
