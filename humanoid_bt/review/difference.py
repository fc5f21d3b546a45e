"""The first quantity in which two ticks differ, by name."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from enum import Enum
from typing import Any, NamedTuple

import numpy as np

from humanoid_bt.core.messages import State
from humanoid_bt.record.tick import Tick

_XYZ, _WXYZ = "xyz", "wxyz"


class Difference(NamedTuple):
    """Where two runs part.

    Attributes:
        time: engine time [s].
        quantity: what differs: ``state joint_positions[left_knee]``, ``command base``, ``node fetch/reach``.
        before: its value in the one.
        after: its value in the other.
    """

    time: float
    quantity: str
    before: Any
    after: Any

    def __str__(self) -> str:
        return f"at {self.time:.3f} s {self.quantity}: {_told(self.before)} became {_told(self.after)}"


def first_difference(before: Tick, after: Tick, joints: Sequence[str] = ()) -> Difference | None:
    """Return the first quantity in which two ticks differ to the bit, None if there is none.

    How long the tree took is no such quantity. What was sensed comes before what was decided.

    Args:
        before, after: the ticks.
        joints: the robot's joints.
    """
    ours, theirs = dict(_quantities(before, joints)), dict(_quantities(after, joints))
    for name in {**ours, **theirs}:
        if not _same(one := ours.get(name), other := theirs.get(name)):
            return Difference(before.state.time, name, one, other)
    return None


def decided_differently(before: Tick, after: Tick) -> Difference | None:
    """Return what two ticks command differently, None if they command the same."""
    ours, theirs = dict(_commanded(before)), dict(_commanded(after))
    for name in {**ours, **theirs}:
        if not _same(one := ours.get(name), other := theirs.get(name)):
            return Difference(before.state.time, name, one, other)
    return None


def _quantities(tick: Tick, joints: Sequence[str]) -> Iterator[tuple[str, Any]]:
    for field in dataclasses.fields(State):
        yield from _parts(f"state {field.name}", getattr(tick.state, field.name), joints)
    for percept in tick.percepts:
        yield from _parts(f"percept {percept.name}", percept, ())
    yield from _commanded(tick)


def _commanded(tick: Tick) -> Iterator[tuple[str, Any]]:
    if tick.command is None:
        return
    for resource, target in tick.command.targets.items():
        yield from _parts(f"command {resource}", target, ())
    for resource, source in tick.command.sources.items():
        yield f"command {resource} from", source


def _parts(name: str, value: Any, joints: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield the numbers and texts of a value, each with its name."""
    if isinstance(value, np.ndarray):
        labels = joints if len(joints) == len(value) else _WXYZ if len(value) == 4 else _XYZ
        for index, number in enumerate(value.tolist()):
            yield f"{name}[{labels[index] if len(labels) == len(value) else index}]", number
    elif dataclasses.is_dataclass(value) and not isinstance(value, type):
        for field in dataclasses.fields(value):
            yield from _parts(f"{name} {field.name}", getattr(value, field.name), joints)
    elif isinstance(value, Mapping):
        for key, part in value.items():
            yield from _parts(f"{name}[{key}]", part, joints)
    elif isinstance(value, (tuple, list)):
        for index, part in enumerate(value):
            yield from _parts(f"{name}[{index}]", part, joints)
    else:
        yield name, value.value if isinstance(value, Enum) else value


def _same(one: Any, other: Any) -> bool:
    """Return whether two values are equal to the bit; a number that is none is equal to itself."""
    return bool(one == other) or (one != one and other != other)  # noqa: PLR0124


def _told(value: Any) -> str:
    return "nothing" if value is None else repr(value)
