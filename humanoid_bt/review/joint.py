"""``explain --joint``: how far a joint went, how much it bore, and when it was limited."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from humanoid_bt.core.errors import UserError, nearest, relative
from humanoid_bt.core.messages import Array
from humanoid_bt.core.units import readable
from humanoid_bt.review.body import FULL
from humanoid_bt.review.cause import Row
from humanoid_bt.review.explanation import Explanation, Moment
from humanoid_bt.review.history import History
from humanoid_bt.review.scene import command_in_force
from humanoid_bt.review.words import cut, doing, several, when

_MOST = 8  # times at a limit that are told
_APART = 0.5  # s between two of them


def joint_explained(history: History, joint: str) -> Explanation:
    """Return the extremes of a joint.

    Raises:
        UserError: the robot has no such joint.
    """
    robot, joints = history.setup["robot"], history.setup["robot"]["joints"]
    if joint not in joints:
        raise UserError(f"the robot {robot['name']!r} has no joint {joint!r}", hint=nearest(joint, joints))
    number = joints.index(joint)
    limits = {name: values[number] for name, values in robot["limits"].items()}
    cycles = history.log.cycles("cycles", columns=["position", "velocity", "torque"], labels=[joint])
    plans = history.log.cycles("plans", columns=["setpoint", "limited"], labels=[joint])
    torque = np.abs(cycles.columns["torque"][:, 0])
    full = _spans(cycles.time[torque >= FULL * limits["torque"]]) if limits["torque"] else []
    clamped = _spans(plans.time[plans.columns["limited"][:, 0] > 0.5])
    worst = float(cycles.time[torque.argmax()]) if len(torque) else 0.0
    moments = [Moment(begin, f"at its torque limit{_lasting(begin, end)}") for begin, end in full]
    moments += [
        Moment(begin, f"setpoint clamped: soft limit, speed or torque{_lasting(begin, end)}") for begin, end in clamped
    ]
    parts = {
        "position": (cycles.time, cycles.columns["position"][:, 0], "rad"),
        "setpoint": (plans.time, plans.columns["setpoint"][:, 0], "rad"),
        "speed": (cycles.time, cycles.columns["velocity"][:, 0], "rad/s"),
        "torque": (cycles.time, cycles.columns["torque"][:, 0], "Nm"),
    }
    return Explanation(
        recording=relative(history.log.path),
        kind="joint",
        headline=f"{joint} bore {_most(torque, worst, limits)}; {_often(len(full), len(clamped))}",
        time=worst,
        rows=[*_rows(parts, limits), *_then(history, worst)],
        title="at limits" if len(moments) <= _MOST else f"at limits, the first {_MOST} of {len(moments)} times",
        moments=sorted(moments)[:_MOST],
        data={
            "limits": limits,
            "extremes": {name: _extremes(*of) for name, of in parts.items()},
            "at_torque_limit": full,
            "clamped": clamped,
        },
    )


def _most(torque: Array, worst: float, limits: dict[str, Any]) -> str:
    if not len(torque):
        return "nothing that is recorded"
    limit = f" of {limits['torque']:g}" if limits["torque"] else ""
    return f"at most {torque.max():.1f}{limit} Nm, at {when(worst)}"


def _often(full: int, clamped: int) -> str:
    counts = ((full, "at its torque limit"), (clamped, "clamped"))
    return " and ".join(f"{several(count, 'time')} {what}" for count, what in counts if count) or "never at a limit"


def _extremes(time: Array, values: Array, _unit: str) -> dict[str, float]:
    if not len(values):
        return {}
    low, high = int(values.argmin()), int(values.argmax())
    return {
        "least": float(values[low]),
        "least_at": float(time[low]),
        "most": float(values[high]),
        "most_at": float(time[high]),
    }


def _rows(parts: dict[str, tuple[Array, Array, str]], limits: dict[str, Any]) -> Iterator[Row]:
    bounds = {
        "position": ("lower", "upper"),
        "setpoint": ("lower", "upper"),
        "speed": ("speed",),
        "torque": ("torque",),
    }
    for name, (time, values, unit) in parts.items():
        if found := _extremes(time, values, unit):
            known = [limits[key] for key in bounds[name] if limits[key] is not None]
            sign = "±" if len(known) == 1 else ""
            limit = f"; limit {sign}{' to '.join(readable(value, unit) for value in known)}" if known else ""
            least, most = readable(found["least"], unit), readable(found["most"], unit)
            yield name, f"{least} at {found['least_at']:.3f} s to {most} at {found['most_at']:.3f} s{limit}"


def _then(history: History, time: float) -> Iterator[Row]:
    """Yield what was commanded when the joint bore most."""
    if told := command_in_force(history, time):
        yield "command", cut(f"at {time:.2f} s {told}", 240)
    if acting := history.acting(time):
        yield "nodes", f"{doing(acting)} ran then"


def _spans(times: Array) -> list[tuple[float, float]]:
    """Return begin and end of runs of times [s]."""
    if not len(times):
        return []
    breaks = np.flatnonzero(np.diff(times) > _APART) + 1
    return [(float(part[0]), float(part[-1])) for part in np.split(times, breaks)]


def _lasting(begin: float, end: float) -> str:
    return f", until {end:.3f} s" if end - begin > 0.01 else ""
