"""Every servo cycle of a recording as tables, a window of time after the other, so that memory stays small."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from humanoid_bt.control.cycle_log import NONE
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.record.reading import AT, Cycles, FlightLog

Places = NDArray[np.intp]

RATE = 200.0
"""Rate of samples unless another is asked for [Hz]: that at which the robot is estimated."""

FULL_RATE = round(1 / SERVO_PERIOD)
"""Rate at which samples are recorded [Hz]."""

_WINDOW = 5000  # servo cycles that are unpacked at once
_HELD = 1.0  # s for which a plan is looked for before a window
_LONGEST_BLOCK = 60.0  # s; the recorder writes one every second at least


def step_of(rate: float) -> int:
    """Return how many servo cycles there are from a sample to the next.

    Raises:
        UserError: the rate is none.
    """
    step = round(FULL_RATE / rate) if isinstance(rate, (int, float)) and 0 < rate <= FULL_RATE else 0
    if not step or not math.isclose(step * rate, FULL_RATE, rel_tol=1e-9):
        hint = "valid: 1000, 500, 200, 100, 50, ...: what divides the 1000 Hz of the servo"
        raise UserError(f"no samples can be had at a rate of {rate!r} Hz", hint=hint)
    return step


def joints(log: FlightLog, begin: float, end: float, step: int) -> Iterator[dict[str, Any]]:
    """Yield columns of the table of joints, a window of time after the other."""
    for cycles, plans, latest in _windows(log, begin, end, step):
        names = cycles.described["position"].labels
        rows, width = len(cycles.time), len(names)
        numbers = np.tile(np.arange(width, dtype=np.int16), rows)
        limited = _held(plans.columns["limited"], latest)
        yield {
            "time": np.repeat(cycles.time, width),
            "joint": pa.DictionaryArray.from_arrays(numbers, pa.array(names, pa.string())),
            **{name: _flat(cycles.columns[name]) for name in ("position", "velocity", "torque")},
            **{
                name: _flat(_held(plans.columns[name], latest))
                for name in ("setpoint", "setpoint_velocity", "feedforward")
            },
            "limited": pa.array(limited.ravel() > 0, mask=np.isnan(limited.ravel())),
        }


def body(log: FlightLog, begin: float, end: float, step: int) -> Iterator[dict[str, Any]]:
    """Yield columns of the table of the body, a window of time after the other."""
    for cycles, plans, latest in _windows(log, begin, end, step):
        columns = cycles.columns
        servo, plan = columns["servo"], _held(plans.columns["plan"], latest)
        errors, com = _held(plans.columns["hand_error"], latest), _held(plans.columns["com_error"], latest)
        none = np.isnan(errors) | (errors == NONE)
        yield {
            "time": cycles.time,
            "mode": _named(servo[:, 1], log.layout["modes"]),
            "gait": _named(plan[:, 1], log.layout["gaits"]),
            "command": pa.array(servo[:, 2].astype(np.int64), mask=servo[:, 2] < 0),
            **_split(columns["base_position"], "x", "y", "z"),
            **_split(columns["base_quaternion"], "qw", "qx", "qy", "qz"),
            **_split(columns["base_velocity"], "vx", "vy", "vz"),
            **_split(columns["base_rate"], "wx", "wy", "wz"),
            **_split(columns["foot_force"], *(f"foot_force_{side}" for side in SIDES)),
            **{
                f"hand_error_{side}": pa.array(errors[:, place], mask=none[:, place])
                for place, side in enumerate(SIDES)
            },
            **_split(com, *(f"com_error_{axis}" for axis in "xyz")),
            "solved": pa.array(plan[:, 2] > 0, mask=np.isnan(plan[:, 2])),
        }


def _windows(log: FlightLog, begin: float, end: float, step: int) -> Iterator[tuple[Cycles, Cycles, Places]]:
    """Yield servo cycles, plans, and which plan was the latest at each cycle, -1 for none.

    Raises:
        UserError: the recording has none of them.
    """
    first, last = log.span
    last = min(last, first + _LONGEST_BLOCK * len(log.blocks["cycles"]))  # a damaged number is no reason to wait
    begin, end = max(begin, first), min(end, last)
    if not (begin <= end + AT and math.isfinite(begin) and math.isfinite(end)):
        return
    since, until = math.ceil((begin - AT) / SERVO_PERIOD), math.floor((end + AT) / SERVO_PERIOD)
    for at in range(since, until + 1, _WINDOW):
        window = at * SERVO_PERIOD, min(at + _WINDOW - 1, until) * SERVO_PERIOD
        cycles = log.cycles("cycles", *window)
        plans = log.cycles("plans", window[0] - _HELD, window[1])
        chosen = np.round(cycles.time / SERVO_PERIOD).astype(np.int64) % step == 0
        kept = {name: numbers[chosen] for name, numbers in cycles.columns.items()}
        found = Cycles(cycles.time[chosen], kept, cycles.described, cycles.damaged)
        latest = np.searchsorted(plans.time, found.time + AT, side="right") - 1
        if len(found.time):
            yield found, plans, latest


def _held(numbers: Array, latest: Places) -> Array:
    """Return the latest row at each cycle; not a number where there was none."""
    if not len(numbers):
        return np.full((len(latest), numbers.shape[1]), np.nan)
    return np.where((latest >= 0)[:, None], numbers[latest], np.nan)


def _flat(numbers: Array) -> Any:
    """Return numbers of joints as one column."""
    return pa.array(numbers.ravel().astype(np.float32), mask=np.isnan(numbers.ravel()))


def _split(numbers: Array, *names: str) -> dict[str, Any]:
    return {name: pa.array(column, mask=np.isnan(column)) for name, column in zip(names, numbers.T, strict=True)}


def _named(numbers: Array, known: list[str]) -> Any:
    """Return the names that numbers stand for; null where one stands for none."""
    places = np.where(np.isnan(numbers), -1, numbers).astype(np.int16)
    unknown = (places < 0) | (places >= len(known))
    return pa.DictionaryArray.from_arrays(pa.array(places, mask=unknown), pa.array(known, pa.string()))
