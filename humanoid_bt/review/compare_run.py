"""How what happened in a run differs from another one: the first moment they part, each node's times, results."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import Enum
from itertools import zip_longest
from typing import Any, NamedTuple

import numpy as np

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import Command, Percept, State
from humanoid_bt.core.units import readable_pair
from humanoid_bt.record.tick import Tick
from humanoid_bt.review.compare_setup import Change
from humanoid_bt.review.happened import Row
from humanoid_bt.review.words import status

_NOT_COMPARED = ("sequence", "command_sequence")  # they only count
_MISSING = object()


class Parting(NamedTuple):
    """The first moment in which two runs are not the same.

    Attributes:
        time: engine time of the tick [s].
        quantity: what differs first: a percept, then the state, then a node, then the command.
        before, after: its value in each.
    """

    time: float
    quantity: str
    before: str
    after: str

    def __str__(self) -> str:
        return f"at {self.time:.3f} s {self.quantity}: {self.before} became {self.after}"


class NodeShift(NamedTuple):
    """The first change of a node that is not the same in two runs.

    Attributes:
        node: its path below the tree's name.
        before, after: status and engine time [s] of the change, None where there is none.
    """

    node: str
    before: tuple[str, float] | None
    after: tuple[str, float] | None

    @property
    def time(self) -> float:
        """The engine time of the earlier of the two [s]."""
        return min(at[1] for at in (self.before, self.after) if at is not None)


def first_parting(
    one: Iterator[Tick],
    other: Iterator[Tick],
    shifts: Sequence[NodeShift],
    joints: Sequence[str],
    tolerance: float = 0.0,
    gaps: bool = False,
) -> Parting | None:
    """Return the first moment in which two runs part, None if they never do.

    Args:
        one, other: the ticks.
        shifts: the first changes of nodes that differ, as :func:`node_shifts` has them.
        joints: names of the robot's joints.
        tolerance: numbers that differ by no more are the same, whatever their unit.
        gaps: whether ticks may be missing in one of them: only those are compared then that are in both.
    """
    found = _of_ticks((_in_both if gaps else zip_longest)(one, other), joints, tolerance)
    node = _of_node(shifts[0]) if shifts else None
    if found is None or node is None:
        return found or node
    sees = not found.quantity.startswith("command")  # what a tick sees comes before what nodes make of it
    return found if found.time < node.time or (found.time == node.time and sees) else node


def tick_parting(before: Tick, after: Tick, joints: Sequence[str], tolerance: float = 0.0) -> Parting | None:
    """Return in what two ticks differ first, None if in nothing; how long the tree took is nothing.

    Args:
        before, after: the ticks.
        joints: names of the robot's joints.
        tolerance: numbers that differ by no more are the same, whatever their unit.
    """
    found = (
        _first_difference("percept", _by_name(before), _by_name(after), tolerance)
        or _state_difference(before.state, after.state, joints, tolerance)
        or _first_difference("command", before.command, after.command, tolerance)
    )
    return None if found is None else Parting(min(before.state.time, after.state.time), *found)


def command_parting(time: float, before: Command | None, after: Command | None) -> Parting | None:
    """Return in what two commands differ first that were given at an engine time [s], None if in nothing."""
    found = _first_difference("command", before, after, 0.0)
    return None if found is None else Parting(time, *found)


def node_parting(time: float, before: tuple[str, str] | None, after: tuple[str, str] | None) -> Parting:
    """Return that nodes, path and status of each, did not change alike at an engine time [s]; None if none did."""
    path = (before or after or ("",))[0]
    texts = [
        "no change" if one is None else status(one[1]) if one[0] == path else f"{one[0]} {status(one[1])}"
        for one in (before, after)
    ]
    return Parting(time, f"node {path}", *texts)


def node_shifts(one: Sequence[Row], other: Sequence[Row], tolerance: float) -> list[NodeShift]:
    """Return for each node the first change that differs, in the order of time.

    Args:
        one, other: changes of nodes.
        tolerance: times that differ by no more are the same [s].
    """
    histories = _histories(one), _histories(other)
    found = []
    for node in dict.fromkeys((*histories[0], *histories[1])):
        pairs = zip_longest(histories[0].get(node, []), histories[1].get(node, []))
        for before, after in pairs:
            if before is None or after is None or before[0] != after[0] or abs(before[1] - after[1]) > tolerance + 1e-9:
                found.append(NodeShift(node, before, after))
                break
    return sorted(found, key=lambda shift: shift.time)


def result_changes(one: Sequence[Row], other: Sequence[Row], tolerance: float) -> Iterator[Change]:
    """Yield the results that nodes reported last, as far as they are not the same."""
    last = _last(one), _last(other)
    for name in dict.fromkeys((*last[0], *last[1])):
        before, after = last[0].get(name), last[1].get(name)
        if before is None or after is None:
            yield Change("results", name, _result(before), _result(after))
        elif _first_difference(name, _value(before), _value(after), tolerance) is not None:
            texts = readable_pair(_value(before), _value(after), before["unit"])
            yield Change("results", name, *texts)


def _below(path: str) -> str:
    """Return a path below the tree's name, which may be another one in the other run."""
    return path.partition("/")[2] or path


def _histories(changes: Sequence[Row]) -> dict[str, list[tuple[str, float]]]:
    found: dict[str, list[tuple[str, float]]] = {}
    for change in changes:
        history = found.setdefault(_below(change["node"]), [])
        if not history or history[-1][0] != change["status"] or change["status"] != "RUNNING":
            history.append((change["status"], change["time"]))
    return found


def _last(results: Sequence[Row]) -> dict[str, Row]:
    return {f"{_below(row['node'])} {row['result']}": row for row in results}


def _value(row: Row) -> Any:
    return row["value"] if row["value"] is not None else row["text"]


def _result(row: Row | None) -> str | None:
    return None if row is None else readable_pair(_value(row), None, row["unit"])[0]


# ---- the first moment -----------------------------------------------------------------------------------------------


def _in_both(one: Iterator[Tick], other: Iterator[Tick]) -> Iterator[tuple[Tick | None, Tick | None]]:
    """Yield the ticks of the same time in two runs, and in the end what only one of them goes on with."""
    before, after = next(one, None), next(other, None)
    while before is not None and after is not None:
        later = before.state.time - after.state.time
        if abs(later) < DECISION_PERIOD / 2:
            yield before, after
        if later < DECISION_PERIOD / 2:
            before = next(one, None)
        if later > -DECISION_PERIOD / 2:
            after = next(other, None)
    yield before, after


def _of_ticks(
    pairs: Iterable[tuple[Tick | None, Tick | None]], joints: Sequence[str], tolerance: float
) -> Parting | None:
    for before, after in pairs:
        if before is None or after is None:
            there = before or after
            if there is None:
                return None
            return Parting(
                there.state.time, "the recording", *("goes on" if t else "has ended" for t in (before, after))
            )
        if found := tick_parting(before, after, joints, tolerance):
            return found
    return None


def _of_node(shift: NodeShift) -> Parting:
    texts = [
        "nothing" if at is None or at[1] != shift.time else f"{shift.node} {status(at[0])}"  # what it did at that time
        for at in (shift.before, shift.after)
    ]
    return Parting(shift.time, "node", *texts)


def _by_name(tick: Tick) -> dict[str, Any]:
    return {percept.name: percept for percept in tick.percepts}


def _state_difference(one: State, other: State, joints: Sequence[str], tolerance: float) -> tuple[str, str, str] | None:
    for field in dataclasses.fields(State):
        if field.name in _NOT_COMPARED:
            continue
        values = getattr(one, field.name), getattr(other, field.name)
        if isinstance(values[0], np.ndarray) and np.array_equal(*values):
            continue
        if field.name.startswith(("joint_", "setpoint_")) and len(joints) == len(values[0]) == len(values[1]):
            values = dict(zip(joints, values[0], strict=True)), dict(zip(joints, values[1], strict=True))
        if found := _first_difference(field.name, *values, tolerance):
            return found
    return None


def _first_difference(name: str, one: Any, other: Any, tolerance: float) -> tuple[str, str, str] | None:
    """Return name and both values of the first part that differs, None if none does."""
    if one is other:
        return None
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        if np.array_equal(one, other):
            return None
        one, other = list(one), list(other)
    if isinstance(one, Mapping) and isinstance(other, Mapping):
        pairs = ((f"{name} {key}", one.get(key, _MISSING), other.get(key, _MISSING)) for key in {**one, **other})
    elif isinstance(one, (list, tuple)) and isinstance(other, (list, tuple)):
        axes = "xyz" if len(one) <= 3 else range(max(len(one), len(other)))
        numbered = zip_longest(one, other, fillvalue=_MISSING)
        pairs = ((f"{name} {axis}", *pair) for axis, pair in zip(axes, numbered, strict=False))
    elif dataclasses.is_dataclass(one) and type(one) is type(other):
        names = [field.name for field in dataclasses.fields(one) if field.name not in _NOT_COMPARED]
        pairs = ((f"{name} {part}", getattr(one, part), getattr(other, part)) for part in names)
    else:
        return None if _equal(one, other, tolerance) else (name, *_texts(one, other))
    return next((found for pair in pairs if (found := _first_difference(*pair, tolerance))), None)


def _equal(one: Any, other: Any, tolerance: float) -> bool:
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return one == other or abs(one - other) <= tolerance or (math.isnan(one) and math.isnan(other))
    return type(one) is type(other) and bool(one == other)


def _texts(one: Any, other: Any) -> tuple[str, str]:
    """Return two values with as many digits as tell them apart."""
    if isinstance(one, float) and isinstance(other, float):
        for digits in range(4, 18):
            texts = f"{one:.{digits}g}", f"{other:.{digits}g}"
            if texts[0] != texts[1]:
                break
        return texts
    return _text(one), _text(other)


def _text(value: Any) -> str:
    if value is _MISSING or value is None:
        return "none"
    if isinstance(value, Enum):
        return str(value.value)
    if isinstance(value, Percept):
        return f"seen at {value.stamp:.2f} s"
    if dataclasses.is_dataclass(value):
        return type(value).__name__
    return f"{value:g}" if isinstance(value, float) else str(value)
