"""What a replay needs to know of a recorded run."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from humanoid_bt.core.clock import cycles
from humanoid_bt.core.messages import Mode
from humanoid_bt.record.reading import FlightLog, News
from humanoid_bt.review.parameters import as_written
from humanoid_bt.review.setup import parameters
from humanoid_bt.robot.config import Walk
from humanoid_bt.session.engine import Input

TO_TREE = ("key", "set", "force")
"""Kinds of inputs that do something to the tree: its next tick is the first that knows."""


@dataclass(frozen=True)
class RecordedRun:
    """A recorded run.

    Attributes:
        mode: lockstep or realtime, "" if nobody knows.
        seed: of everything random.
        joints: the robot's.
        given: parameters that were given from outside, as they were written.
        duration: its limit [s], infinity for none.
        waits: whether it waited for the reset of an emergency stop.
        body: what walked and balanced.
        ended: whether it says how it ended.
        outcome, reason: how, and why.
        tree_ended: engine time at which the tree ended [s], infinity if that is not known.
        rested: whether it went on after that, and waited for an edit.
        edited: engine time of the first edit of the tree [s], infinity for none.
        estops: servo cycle, source and reason of every emergency stop.
        inputs: what else came from outside; what was done to the tree has the time of the tick that it was done before.
        nodes: time, path, status and feedback of every change of a node's status.
    """

    mode: str = ""
    seed: int = 0
    joints: tuple[str, ...] = ()
    given: dict[str, Any] = field(default_factory=dict)
    duration: float = math.inf
    waits: bool = False
    body: Walk = "dcm"
    ended: bool = False
    outcome: str = ""
    reason: str = ""
    tree_ended: float = math.inf
    rested: bool = False
    edited: float = math.inf
    estops: tuple[tuple[int, str, str], ...] = ()
    inputs: tuple[Input, ...] = ()
    nodes: tuple[tuple[float, str, str, str], ...] = ()


def recorded_run(log: FlightLog) -> RecordedRun:
    """Return what a recording says about its run."""
    news = log.news
    limits, end = (_last(news, kind) for kind in ("limits", "end"))
    duration, ended = (limits or {}).get("duration"), (end or {}).get("tree_ended")
    stops = [one.value for one in news if one.kind == "stop"]
    return RecordedRun(
        mode=log.setup["mode"],
        seed=log.setup["seed"],
        joints=tuple(log.setup["robot"]["joints"]),
        given={name: as_written(found) for name, found in parameters(log.setup["tree"]).items() if found.given},
        duration=math.inf if duration is None else duration,
        waits=limits is not None and limits["waits"],
        body=log.setup.get("body", "dcm"),
        ended=end is not None,
        outcome=end["outcome"] if end else "",
        reason=end["reason"] if end else "",
        tree_ended=math.inf if ended is None else ended,
        rested=log.setup.get("watch") is True and end is not None and end["outcome"] in ("success", "failure"),
        edited=next((one.time for one in news if one.kind == "tree"), math.inf),
        estops=tuple(
            (cycles(stop["time"]), stop["source"], stop["reason"])
            for stop in stops
            if stop["mode"] == Mode.EMERGENCY_STOP.name.lower()
        ),
        inputs=tuple(
            given._replace(time=one.time) if given.kind in TO_TREE else given
            for one in news
            if one.kind == "input"
            for given in [Input(*one.value)]
        ),
        nodes=tuple((one.time, *one.value) for one in news if one.kind == "node"),
    )


def _last(news: Sequence[News], kind: str) -> Mapping[str, Any] | None:
    """Return the last news of a kind, None if there are none."""
    return next((one.value for one in reversed(news) if one.kind == kind), None)
