"""What a replay needs to know of a recorded run; what is not as it should be, whoever wrote it, is left out."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.messages import Mode
from humanoid_bt.record.reading import FlightLog
from humanoid_bt.session.engine import Input

_NUMBER = (int, float)
_INPUTS = {"push": list, "reset": str, "reset_after_tick": str}


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
        ended: whether it says how it ended.
        outcome, reason: how, and why.
        tree_ended: engine time at which the tree ended [s], infinity if that is not known.
        edited: engine time of the first edit of the tree [s], infinity for none.
        estops: servo cycle, source and reason of every emergency stop.
        inputs: what else came from outside.
        nodes: time, path, status and feedback of every change of a node's status.
    """

    mode: str = ""
    seed: int = 0
    joints: tuple[str, ...] = ()
    given: dict[str, Any] = field(default_factory=dict)
    duration: float = math.inf
    waits: bool = False
    ended: bool = False
    outcome: str = ""
    reason: str = ""
    tree_ended: float = math.inf
    edited: float = math.inf
    estops: tuple[tuple[int, str, str], ...] = ()
    inputs: tuple[Input, ...] = ()
    nodes: tuple[tuple[float, str, str, str], ...] = ()


def recorded_run(log: FlightLog) -> RecordedRun:
    """Return what a recording says about its run."""
    last: dict[str, dict[str, Any]] = {}
    for news in log.news:
        if news.kind in ("limits", "end") and isinstance(news.value, dict):
            last[news.kind] = news.value
    limits, end = last.get("limits", {}), last.get("end", {})
    seed, ended = log.setup.get("seed"), end.get("tree_ended")
    return RecordedRun(
        mode=str(log.setup.get("mode", "")),
        seed=seed if isinstance(seed, int) else 0,
        joints=tuple(map(str, _of(log.setup.get("robot"), "joints", list))),
        given={
            name: entry["written"]
            for name, entry in _of(log.setup.get("tree"), "parameters", dict).items()
            if isinstance(entry, dict) and entry.get("from") == "given" and "written" in entry
        },
        duration=_time(limits.get("duration")),
        waits=bool(limits.get("waits")),
        ended="end" in last,
        outcome=str(end.get("outcome", "")),
        reason=str(end.get("reason", "")),
        tree_ended=_time(ended),
        edited=next((news.time for news in log.news if news.kind == "tree"), math.inf),
        estops=tuple(
            (round(stop["time"] / SERVO_PERIOD), str(stop.get("source")), str(stop.get("reason")))
            for stop in _values(log, "stop", dict)
            if stop.get("mode") == Mode.EMERGENCY_STOP.name.lower() and math.isfinite(_time(stop.get("time")))
        ),
        inputs=tuple(Input(*value) for value in _values(log, "input", list) if _is_input(value)),
        nodes=tuple(
            (news.time, *news.value)
            for news in log.news
            if news.kind == "node" and isinstance(news.value, list) and list(map(type, news.value)) == [str] * 3
        ),
    )


def _of(data: Any, key: str, kind: type) -> Any:
    """Return what a mapping has under a key, if both are what they should be; else nothing of that kind."""
    found = data.get(key) if isinstance(data, dict) else None
    return found if isinstance(found, kind) else kind()


def _time(value: Any) -> float:
    """Return a time [s], infinity if it is none."""
    return float(value) if isinstance(value, _NUMBER) and math.isfinite(value) and abs(value) < 1e9 else math.inf


def _values(log: FlightLog, kind: str, of: type) -> list[Any]:
    return [news.value for news in log.news if news.kind == kind and isinstance(news.value, of)]


def _is_input(value: list[Any]) -> bool:
    if len(value) != 3 or not math.isfinite(_time(value[0])) or value[1] not in _INPUTS:
        return False
    if value[1] != "push":
        return isinstance(value[2], str)
    push = value[2] if isinstance(value[2], list) and len(value[2]) == 3 else [None] * 3
    body, force, duration = push
    numbers = [*force, duration] if isinstance(force, list) and len(force) == 3 else [None]
    return isinstance(body, str) and all(math.isfinite(_time(number)) for number in numbers)
