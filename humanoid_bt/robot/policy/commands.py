"""Which velocities a learned walker can be commanded, as its description or its model's metadata says."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.core.messages import Array
from humanoid_bt.core.units import readable
from humanoid_bt.robot.policy.config import Axis, PolicyConfig
from humanoid_bt.robot.policy.network import Metadata

_RANGES = "command_ranges"
RANGE_KEYS: dict[Axis, str] = {"vx": "lin_vel_x", "vy": "lin_vel_y", "wz": "ang_vel_yaw"}
_WAYS = (
    ("walk backward", "walk to the right", "turn to the right"),
    ("walk ahead", "walk to the left", "turn to the left"),
)
_PAIR = 2


def command_range(config: PolicyConfig, axis: Axis, metadata: Metadata) -> tuple[float, float]:
    """Return the least and the largest command of an axis [m/s], [rad/s].

    Raises:
        UserError: there are none, or they are no range around 0.
    """
    found: Any = getattr(config.command, axis)
    place, hint, what = config.place("command", axis), f"{axis}: [least, largest]", str(axis)
    if found is None:
        known, key = metadata.get(_RANGES), RANGE_KEYS[axis]
        if known is None:
            message = f"there is no 'command.{axis}', and the model's metadata has no {_RANGES}"
            raise UserError(message, config.place("command"), hint, code="policy")
        place = config.place("model")
        if not isinstance(known, dict):
            hint = f"with {', '.join(RANGE_KEYS.values())}; or write vx, vy and wz here"
            message = f"{_RANGES} of the model's metadata is no mapping, but {readable(known)}"
            raise UserError(message, place, hint, code="policy")
        if known.get(key) is None:
            message = f"{_RANGES} of the model's metadata has no {key!r}: it is {readable(known)}"
            raise UserError(message, place, hint, code="policy")
        found, what = known[key], f"{axis} ({key} in {_RANGES} of the model's metadata)"
    numbers = list(found) if isinstance(found, (list, tuple)) else []
    if len(numbers) != _PAIR or not all(_is_finite(number) for number in numbers):
        message = f"the range of {what} must be two finite numbers, not {readable(found)}"
        raise UserError(message, place, hint, code="policy")
    low, high = map(float, numbers)
    if not low <= 0 <= high:
        message = f"the range of {what}, {low:g} to {high:g}, does not hold 0: it could not stand"
        raise UserError(message, place, hint, code="policy")
    return low, high


def command_problems(config: PolicyConfig, ranges: Array) -> Iterator[Problem]:
    """Yield commands with which it would never walk.

    Args:
        config: its description.
        ranges: least and largest vx, vy [m/s] and wz [rad/s], shape (2, 3).
    """
    command = config.command
    fastest, hint = float(np.abs(ranges[:, :2]).max()), "vx: [least, largest]"
    if not fastest:
        yield Problem("the ranges of vx and vy are 0: it could not walk", config.place("command"), hint, code="policy")
    elif fastest < command.stand_below:
        message = (
            f"all of the ranges of vx and vy is slower than 'stand_below', {command.stand_below:g}: it could not walk"
        )
        yield Problem(message, config.place("command"), hint, code="policy")
    least, which = min((command.slowest, "slowest"), (command.slowest_turn, "slowest_turn"))
    if command.stand_below >= least:
        message = f"a command as slow as '{which}', {least:g}, would be one to stand"
        place = config.place("command", "stand_below")
        yield Problem(message, place, f"stand_below: less than {least:g}", code="policy")


def impossible(ranges: Array) -> list[str]:
    """Return which ways a walker cannot be commanded, of its ranges, shape (2, 3)."""
    return [
        way
        for ways, bounds in zip(_WAYS, ranges, strict=True)
        for way, bound in zip(ways, bounds, strict=True)
        if not bound
    ]


def _is_finite(number: object) -> bool:
    return isinstance(number, (int, float)) and not isinstance(number, bool) and math.isfinite(number)
