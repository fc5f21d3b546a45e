"""How a review words what it found: names of nodes, commands, percepts, moments."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from typing import Any

from humanoid_bt.core.messages import (
    ArmTarget,
    Array,
    BaseTarget,
    GazeTarget,
    HandTarget,
    Pointing,
    PostureTarget,
    Target,
)
from humanoid_bt.core.texts import one_line
from humanoid_bt.core.units import readable
from humanoid_bt.review.history import Change, Sight

SIGNS = {"RUNNING": "▶", "SUCCESS": "✓", "FAILURE": "✗", "INVALID": "○"}
_LONGEST = 120  # characters of what a node says
_LINE = re.compile(r":\d+:\d+$")


def last(path: str) -> str:
    """Return the last name of a node's path."""
    return path.rsplit("/", 1)[-1]


def cut(text: str, longest: int = _LONGEST) -> str:
    """Return a text as one line of limited length."""
    text = one_line(text).strip()
    return text if len(text) <= longest else text[: longest - 1] + "…"


def when(time: float) -> str:
    """Return a moment to the millisecond."""
    return f"{time:.3f} s"


def several(number: int, noun: str) -> str:
    """Return a number of things."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def mentions(text: str, name: str) -> bool:
    """Return whether a text has a name as a word of its own."""
    return re.search(rf"(?<!\w){re.escape(name)}(?!\w)", text) is not None


def line_of(place: str) -> str:
    """Return file and line of a place, without the column."""
    return place.rsplit(":", 1)[0] if _LINE.search(place) else place


def changed(change: Change) -> str:
    """Return a change of a node's status as a line."""
    return cut(f"{SIGNS.get(change.status, '?')} {last(change.path)}  {change.said}")


def status(name: str) -> str:
    """Return the name of a status as people read it, and as ``--break`` takes it: py_trees' is INVALID where halted."""
    return "HALTED" if name == "INVALID" else name


def reported(results: Iterable[tuple[str, Any, str]]) -> str:
    """Return what a skill reported: name, value and unit of each."""
    return ", ".join(f"{name.replace('_', ' ')} {readable(value, unit)}" for name, value, unit in results)


def doing(acting: list[Change]) -> str:
    """Return the names of nodes that act, quoted; "" if none does."""
    return " and ".join(f"'{last(change.path)}'" for change in acting[-2:])


def target(resource: str, of: Target) -> str:
    """Return what is commanded of a resource."""
    name = resource.replace("_", " ")
    match of:
        case BaseTarget(position=position, heading=heading):
            return f"{name} to {_point(position)}, heading {_turned(heading)} deg"
        case HandTarget(position=position):
            return f"{name} to {_point(position)}{_manner(of)}"
        case ArmTarget(joints=joints):
            angles = ", ".join(f"{joint} {math.degrees(angle):z.0f}" for joint, angle in joints.items())
            return f"{name.replace('hand', 'arm')} at {angles} deg{_at_most(of.speed, 'rad/s')}"
        case GazeTarget(point=point):
            return f"{name} at {_point(point)}"
        case PostureTarget(height=height):
            return f"{name} {height * 100:+z.1f} cm"


def _turned(angle: float) -> str:
    """Return an angle that may have been counted over several turns [rad] in degrees, within half a turn."""
    return f"{math.degrees(math.remainder(angle, math.tau)):z.0f}"


def _manner(hand: HandTarget) -> str:
    """Return how a hand is to move, besides where to."""
    said = " from the other palm" if hand.relative else ""
    match hand.orientation:
        case None:
            pass
        case Pointing(direction=direction, axis=axis):
            said += f", {axis} along {_numbers(direction)}"
        case orientation:
            said += f", turned to {_numbers(orientation)}"
    return said + _at_most(hand.speed, "m/s")


def _at_most(speed: float | None, unit: str) -> str:
    return "" if speed is None else f", at most {speed:g} {unit}"


def command(number: int, targets: Mapping[str, Target], sources: Mapping[str, str]) -> str:
    """Return a command with who asked for each part of it."""
    if not targets:
        return f"#{number}: nothing is asked for, the robot stands"
    by_node: dict[str, list[str]] = {}
    for resource, of in targets.items():
        by_node.setdefault(last(sources.get(resource, "?")), []).append(target(resource, of))
    return f"#{number}: " + "; ".join(f"'{node}': {', '.join(parts)}" for node, parts in by_node.items())


def sight(of: Sight) -> str:
    """Return what was known of a percept."""
    age = "just now" if of.age < 5e-4 else f"{of.age:.2f} s ago"
    return f"{of.name} seen {age}, confidence {of.confidence:.2f}, {readable(of.distance, 'm')} away"


def _point(position: Array) -> str:
    return f"{_numbers(position)} m"


def _numbers(values: Array) -> str:
    return "(" + ", ".join(f"{number:z.2f}" for number in values.tolist()) + ")"
