"""Every tick of a recording as rows of tables."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np

from humanoid_bt.core.messages import (
    SIDES,
    ArmTarget,
    Array,
    BaseTarget,
    GazeTarget,
    HandTarget,
    Pointing,
    PostureTarget,
    Target,
)
from humanoid_bt.record.tick import Tick
from humanoid_bt.review.happened import Row, Running

_BETWEEN = " | "  # several names in one text
_DEVIATIONS = ("deviation_x", "deviation_y", "deviation_z")


def ticks(found: Iterable[Tick], changes: Iterable[Row]) -> Iterator[Row]:
    """Yield a row for each tick.

    Args:
        found: the ticks.
        changes: of nodes, from the beginning of the run on.
    """
    running = Running(changes)
    for tick in found:
        state = tick.state
        hands = {f"hand_{side}_": state.hands[side] for side in SIDES if side in state.hands}
        yield {
            "time": state.time,
            "took": tick.took or None,
            "running": running.at(state.time),
            "mode": state.mode.value,
            "gait": state.gait.value,
            "settled": state.base_settled,
            "command": None if tick.command is None else tick.command.sequence,
            **dict(zip(("stance_x", "stance_y", "stance_heading"), map(float, state.stance), strict=False)),
            **{
                f"{name}{axis}": float(x)
                for name, at in {"com_": state.com, **hands}.items()
                for axis, x in zip("xyz", at, strict=False)
            },
            "limited": _BETWEEN.join(state.limit_flags),
            "stop_reason": state.stop_reason,
        }


def percepts(found: Iterable[Tick]) -> Iterator[Row]:
    """Yield a row for each percept, with the time at which the tree had it."""
    for tick in found:
        for percept in tick.percepts:
            x, y, z = map(float, percept.position)
            yield {
                "time": tick.state.time,
                "name": percept.name,
                "stamp": percept.stamp,
                "age": tick.state.time - percept.stamp,
                **{"x": x, "y": y, "z": z, "distance": math.hypot(x, y)},
                "confidence": percept.confidence,
                **({} if percept.size is None else _numbers(percept.size, ("length", "width", "height"))),
                "heading": None if percept.size is None else percept.heading,
                **({} if (turn := percept.orientation) is None else _numbers(turn, ("qw", "qx", "qy", "qz"))),
                "class": percept.class_name or None,
                **({} if (spread := percept.covariance) is None else _numbers(np.sqrt(np.diag(spread)), _DEVIATIONS)),
            }


def contacts(found: Iterable[Tick]) -> Iterator[Row]:
    """Yield a row for each contact that a tick felt."""
    for tick in found:
        for group, contact in tick.state.contacts.items():
            yield {
                "time": tick.state.time,
                "group": group,
                "force": math.hypot(*contact.force),
                **_numbers(contact.force, "xyz"),
                "largest": contact.largest,
                "yields": contact.yields,
            }


def commands(found: Iterable[Tick]) -> Iterator[Row]:
    """Yield a row for each resource that a tick commanded."""
    for tick in found:
        if tick.command is not None:
            for resource, target in tick.command.targets.items():
                yield {
                    "time": tick.state.time,
                    "sequence": tick.command.sequence,
                    "resource": resource,
                    "node": tick.command.sources.get(resource),
                    **target_values(target),
                }


def target_values(target: Target) -> dict[str, Any]:
    """Return the numbers of a target by the names of their columns."""
    match target:
        case BaseTarget(position, heading):
            return {"x": float(position[0]), "y": float(position[1]), "heading": heading}
        case HandTarget(position):
            return {**_numbers(position, "xyz"), **_manner(target), "speed": target.speed, "press": target.press}
        case ArmTarget(joints, speed):
            return {"joints": json.dumps(dict(joints)), "speed": speed}
        case GazeTarget(point):
            return _numbers(point, "xyz")
        case PostureTarget(height):
            return {"height": height}


def _manner(hand: HandTarget) -> dict[str, Any]:
    """Return how a hand is to move, besides where to and how fast."""
    values: dict[str, Any] = {"relative": hand.relative}
    match hand.orientation:
        case None:
            return values
        case Pointing(direction, axis):
            return {**values, "axis": axis, **_numbers(direction, ("dx", "dy", "dz"))}
        case orientation:
            return {**values, **_numbers(orientation, ("qw", "qx", "qy", "qz"))}


def _numbers(values: Array, names: Iterable[str]) -> dict[str, float]:
    return dict(zip(names, map(float, values), strict=False))
