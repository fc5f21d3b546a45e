"""What skills ask of the robot, as the numbers of targets: checked, with one message for what is none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, get_args

import numpy as np

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.geometry import quaternion
from humanoid_bt.core.messages import SIDES, WORKSPACE, Array, HandTarget, PalmAxis, Pointing, Side, Target
from humanoid_bt.core.texts import shortened

_SHOWN = 80  # characters of what is no number
_ALMOST = 1e-2  # of a length from 1, and of a rotation matrix from one: more is no rounding


def vector(values: Any, size: int, what: str = "position") -> Array:
    """Return numbers, shape (size,), that nobody can write into; raises ValueError if they are not finite."""
    found = _vector(values, size, what)
    _check_finite(found, what)
    return found


def place(values: Any, size: int) -> Array:
    """Return a position, shape (size,) [m]; raises ValueError if it is not finite, or out of the world."""
    found = _vector(values, size, "position")
    for value in found.tolist():
        if not -WORKSPACE <= value <= WORKSPACE:
            _check_finite(found, "position")
            raise ValueError(f"a target's position must be within {WORKSPACE:g} m of the origin, not {found.tolist()}")
    return found


def places(values: Any, what: str) -> Array:
    """Return positions, shape (n, 2) [m], also where there are none; raises ValueError as :func:`place`.

    Args:
        values: them.
        what: what they are, for messages.
    """
    found = _numbers(values, what, "(n, 2)")
    if not found.size:
        return np.empty((0, 2))
    if found.ndim != 2 or found.shape[1] != 2:
        raise ValueError(f"{what} must have shape (n, 2), not {found.shape}")
    for x, y in found.tolist():
        if not (-WORKSPACE <= x <= WORKSPACE and -WORKSPACE <= y <= WORKSPACE):
            raise ValueError(f"{what} must be within {WORKSPACE:g} m of the origin, not {found.tolist()}")
    return found


def number(value: Any, what: str, most: float, unit: str, least: float | None = None) -> float:
    """Return a number; raises ValueError if it is not finite, or out of its range.

    Args:
        value: it.
        what: what it is, for messages.
        most: the largest one, in this unit.
        unit: SI unit.
        least: the smallest one, the largest one's negative if None.
    """
    found, least = real(value, f"a target's {what}", unit), -most if least is None else least
    if not math.isfinite(found):
        raise ValueError(f"a target's {what} must be finite, not {found}")
    if not least <= found <= most:
        raise ValueError(f"a target's {what} must be from {least:g} to {most:g} {unit}, not {found:g}")
    return found


def real(value: Any, what: str, unit: str) -> float:
    """Return a number, which need not be finite; raises ValueError if it is none."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise ValueError(f"{what} must be a number [{unit}], not {shortened(repr(value), _SHOWN)}") from None


def angles(joints: Any) -> dict[str, float]:
    """Return angles of joints by name [rad]; raises ValueError if they are no numbers by name."""
    if not isinstance(joints, Mapping):
        why = f"must be angles [rad] by name, not {shortened(repr(joints), _SHOWN)}"
        raise ValueError(f"the joints of an arm {why}")
    return {name: real(angle, f"the angle of {name!r}", "rad") for name, angle in joints.items()}


def speed_of(value: Any) -> float | None:
    """Return a speed, None for the robot's own; raises ValueError if it is not above 0."""
    if value is None:
        return None
    found = real(value, "the speed of a motion", "m/s or rad/s")
    if not (math.isfinite(found) and found > 0):
        raise ValueError(f"the speed of a motion must be above 0, not {found:g}")
    return found


def side_of(value: Side) -> Side:
    """Return a side of the robot; raises ValueError if it is none."""
    if value not in SIDES:
        raise ValueError(f"a side is 'left' or 'right', not {value!r}")
    return value


def how_turned(orientation: Any, direction: Any, axis: str) -> Array | Pointing | None:
    """Return how a palm is to be turned, None for any way.

    Args:
        orientation: quaternion wxyz, shape (4,), or rotation matrix, shape (3, 3); None for none.
        direction: shape (3,), where an axis of the palm is to point; None for none.
        axis: which one.

    Raises:
        ValueError: these are none, or both are given.
    """
    if orientation is not None and direction is not None:
        raise ValueError("a hand's target takes an orientation or a direction, not both")
    if axis not in get_args(PalmAxis):
        raise ValueError(f"the axis of a palm is 'fingers' or 'facing', not {axis!r}")
    if direction is not None:
        found = vector(direction, 3, "direction")
        largest = float(np.abs(found).max())
        if largest == 0:
            raise ValueError("a target's direction must not be zero")
        found = found / largest  # whose square neither overflows nor is lost
        return Pointing(_kept(found / math.sqrt(found @ found)), axis)  # type: ignore[arg-type]  # it is one of them
    if orientation is None:
        return None
    turn = _numbers(orientation, "a target's orientation", "(4,) or (3, 3)")
    if turn.shape == (3, 3):
        matrix = vector(turn.ravel(), 9, "orientation").reshape(3, 3)
        if np.abs(matrix @ matrix.T - np.eye(3)).max() > _ALMOST or np.linalg.det(matrix) < 0:
            raise ValueError(f"a target's orientation is no rotation matrix: {matrix.tolist()}")
        return _kept(quaternion(matrix))
    if turn.shape != (4,):
        raise ValueError(f"a target's orientation must have shape (4,), w x y z, or (3, 3), not {turn.shape}")
    found = vector(turn, 4, "orientation")
    length = math.sqrt(found @ found)
    if abs(length - 1) > _ALMOST:
        raise ValueError(f"a target's orientation is no unit quaternion (w, x, y, z): {found.tolist()}")
    return _kept(found / length)


def _vector(values: Any, size: int, what: str) -> Array:
    """Return numbers, shape (size,), that nobody can write into; they need not be finite."""
    found = _array(values)
    if found.shape != (size,):
        if not found.ndim:
            raise _no_numbers(values, f"a target's {what}", f"({size},)")
        raise ValueError(f"a target's {what} must have shape ({size},), not {found.shape}")
    found.setflags(write=False)
    return found


def _check_finite(values: Array, what: str) -> None:
    if not all(map(math.isfinite, values.tolist())):
        raise ValueError(f"a target's {what} must be finite, not {values.tolist()}")


def _numbers(values: Any, what: str, shape: str) -> Array:
    found = _array(values)
    if not found.ndim:
        raise _no_numbers(values, what, shape)
    return found


def _array(values: Any) -> Array:
    """Return a copy of numbers; what is none, or a single one, has no axis."""
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError):
        return np.empty(())


def _no_numbers(values: Any, what: str, shape: str) -> ValueError:
    return ValueError(f"{what} must be numbers, shape {shape}, not {shortened(repr(values), _SHOWN)}")


def _kept(values: Array) -> Array:
    values.setflags(write=False)
    return values


def check_relative(targets: Mapping[str, Target]) -> None:
    """Refuse that a node moves a hand where the other one is, unless it moves that one to a place of its own.

    Args:
        targets: of one node, by resource.

    Raises:
        HumanoidBtError: it does.
    """
    for resource, target in targets.items():
        if not isinstance(target, HandTarget) or not target.relative:
            continue
        side, other = SIDES if resource == "left_hand" else SIDES[::-1]
        leader = targets.get(f"{other}_hand")
        if not isinstance(leader, HandTarget) or leader.relative:
            why = f"relative to the {other} one, which it does not move to a place in the world"
            raise HumanoidBtError(f"it moves the {side} hand {why}")
