"""What a body of the user's own answers, taken as what it should be, or refused in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from humanoid_bt.control.body.body import Footstep, Setpoint
from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import SIDES, Array, Gait, Side

_FIELDS = ("position", "velocity", "torque")
_GAINS = ("stiffness", "damping")


class Unusable(HumanoidBtError):  # noqa: N818 (the name says it)
    """An answer that cannot be used; the text says which one, and why."""


def setpoint(answer: Any, joints: Sequence[str]) -> Setpoint:
    """Return a setpoint of these joints, of arrays that are nobody else's.

    Raises:
        Unusable: it is none that the servo could follow.
    """
    if not isinstance(answer, Setpoint):
        raise Unusable(f"update returns {_called(answer)}, it must be a Setpoint")
    fields = {field: _numbers(f"the setpoint's {field}", getattr(answer, field), (len(joints),)) for field in _FIELDS}
    for field, values in fields.items():
        _refuse_where(~np.isfinite(values), values, field, joints, "finite")
    for field in _GAINS:
        if (given := getattr(answer, field)) is not None:
            values = fields[field] = _numbers(f"the setpoint's {field}", given, (len(joints),))
            _refuse_where(~(np.isfinite(values) & (values >= 0)), values, field, joints, "finite, and 0 or more")
    return Setpoint(**fields)


def distance(what: str, answer: Any) -> float | None:
    """Return a distance, None if there is none; raises as the others."""
    return None if answer is None else _number(what, answer)


def com_error(answer: Any) -> Array:
    """Return where the centre of mass is, seen from where it was to go, shape (3,); raises as the others."""
    return _finite("com_error", answer)


def _gait(what: str, answer: Any) -> Gait:
    if not isinstance(answer, Gait):
        raise Unusable(f"{what} is {_called(answer)}, it must be a Gait")
    return answer


def _text(what: str, answer: Any) -> str:
    if not isinstance(answer, str):
        raise Unusable(f"{what} is {_called(answer)}, it must be a text")
    return answer


def _number(what: str, answer: Any) -> float:
    value = _numbers(what, answer, ()).item()
    if math.isnan(value):
        raise Unusable(f"{what} is nan, it must be a number")
    return float(value)


def _finite(what: str, answer: Any) -> Array:
    values = _numbers(what, answer, (3,))
    if not np.isfinite(values).all():
        raise Unusable(f"{what} is {values.tolist()}, it must be finite")
    return values


def _footsteps(what: str, answer: Any) -> tuple[Footstep, ...]:
    steps = tuple(answer)
    for step in steps:
        if not isinstance(step, Footstep) or step.side not in SIDES:
            raise Unusable(f"{what} has {_called(step)}, each must be a Footstep")
        _finite(f"the pose in {what}", step.pose)
    return steps


def _obstacles(what: str, answer: Any) -> dict[Side, str]:
    if not isinstance(answer, Mapping):
        raise Unusable(f"{what} is {_called(answer)}, it must be a mapping of sides to links")
    return {side: _text(what, answer[side]) for side in SIDES if side in answer}


SAID: Mapping[str, Callable[[str, Any], Any]] = {
    "gait": _gait,
    "still_for": _number,
    "stance": _finite,
    "footsteps": _footsteps,
    "com_speed": _number,
    "hand_obstacles": _obstacles,
    "fault": _text,
    "failure": _text,
}
"""What a body says of itself -> what takes it, from its name and the answer; raises Unusable."""


def _numbers(what: str, answer: Any, shape: tuple[int, ...]) -> Array:
    try:
        values: Array = np.array(answer, dtype=float)
    except (TypeError, ValueError) as error:
        raise Unusable(f"{what} is {_called(answer)}, it must be numbers of shape {shape}") from error
    if values.shape != shape:
        raise Unusable(f"{what} has the shape {values.shape}, it must be {shape}")
    return values


def _refuse_where(wrong: Any, values: Array, field: str, joints: Sequence[str], right: str) -> None:
    if wrong.any():
        joint = int(wrong.argmax())
        raise Unusable(f"the setpoint's {field} of {joints[joint]!r} is {values[joint]:g}, it must be {right}")


def _called(answer: Any) -> str:
    return "None" if answer is None else f"a value of type {type(answer).__name__}"
