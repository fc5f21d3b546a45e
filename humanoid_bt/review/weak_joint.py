"""Joints that are too weak for what they bear: off their setpoints, or at their torque limits for long."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from humanoid_bt.core.messages import Array
from humanoid_bt.core.units import readable
from humanoid_bt.record.reading import FlightLog
from humanoid_bt.review.body import FULL, stretches

_OFF = 0.1  # rad by which a joint is further off its setpoint than it usually is
_OFF_FOR = 200  # servo cycles that it must be so at a stretch: a step's swing and landing are shorter
_FULL_FOR = 100  # servo cycles that it must be at its torque limit at a stretch
_FULL_MEANWHILE = 20  # servo cycles at its limit that explain why it was off its setpoint
_LABOURS = 20  # servo cycles at its torque limit at a stretch that no step takes of a joint
_BEFORE = 1.0  # s before balance was lost until which joints show how far they usually are off their setpoints
_STILL = 0.5  # s before balance was lost until which it must have lasted
_NOTHING = 0.02  # share of its torque limit that a drive must exceed to be one: noise and friction are less
_IDLE_FOR = 100  # servo cycles in all that it must be off its setpoint meanwhile
_WITH = 0.05  # s after it, until which it must have begun: later may be what comes of it


class GaveWay(NamedTuple):
    """A joint gave way.

    Attributes:
        joint: its name.
        begin, end: when [s].
        full: whether it was at its torque limit meanwhile.
        off: how far it was from its setpoint at most [rad].
        torque, limit: the largest it gave, and what it should be able to give [Nm]; the latter 0 if it has no limit.
        late: whether balance had been lost before, so that it may be what came of that.
        dead: whether its drive gave nothing all the time, however far it was from its setpoint.
    """

    joint: str
    begin: float
    end: float
    full: bool
    off: float
    torque: float
    limit: float
    late: bool = False
    dead: bool = False

    @property
    def what(self) -> str:
        """What befell it, in words."""
        if self.dead:
            return f"{self.joint} gave next to no torque from {self.begin:.2f} s on"
        what = "was at its torque limit" if self.full else "left its setpoint"
        return f"{self.joint} {what} at {self.begin:.2f} s"

    def __str__(self) -> str:
        of = f" of {self.limit:g}" if self.limit else ""
        off = f"up to {readable(self.off, 'rad')} off its setpoint"
        return f"{self.joint} {off}, {self.begin:.2f} to {self.end:.2f} s, with at most {self.torque:.1f}{of} Nm"


def gave_way(log: FlightLog, begin: float, lost: float, end: float) -> GaveWay | None:
    """Return the joint that gave way first as balance was lost or after that, None if none did.

    Args:
        log: the recording.
        begin: engine time from which on it is looked for [s].
        lost: when balance was lost [s].
        end: when the robot had fallen [s].
    """
    cycles = log.cycles("cycles", begin, end, ["position", "torque"])
    plans = log.cycles("plans", begin, end, ["setpoint"])
    if not len(cycles.time) or not len(plans.time):
        return None
    plan = (plans.time.searchsorted(cycles.time, side="right") - 1).clip(0)
    off = np.abs(cycles.columns["position"] - plans.columns["setpoint"][plan])
    torque = np.abs(cycles.columns["torque"])
    earlier = int(cycles.time.searchsorted(lost - _BEFORE))
    usual = np.median(off[:earlier], axis=0) if earlier else np.zeros(off.shape[1])
    robot, found = log.setup["robot"], list[GaveWay]()
    for number, (joint, most) in enumerate(zip(robot["joints"], robot["limits"]["torque"], strict=True)):
        limit = most or 0.0
        full = (torque[:, number] >= FULL * limit) if limit else np.zeros(len(torque), bool)
        spans = [*stretches(full, _FULL_FOR), *stretches(off[:, number] > usual[number] + _OFF, _OFF_FOR)]
        for first, after in spans:
            began, ended = float(cycles.time[first]), float(cycles.time[after - 1])
            if ended < lost - _STILL:
                continue
            is_full = int(full[first:after].sum()) >= _FULL_MEANWHILE
            angle, given = float(off[first:after, number].max()), float(torque[first:after, number].max())
            found.append(GaveWay(joint, began, ended, is_full, angle, given, limit, began > lost + _WITH))
    balanced = int(cycles.time.searchsorted(lost))
    found += _dead(log, cycles.time[:balanced], off[:balanced], torque[:balanced])
    return min(found, key=lambda of: of.begin, default=None)


def _dead(log: FlightLog, time: Array, off: Array, torque: Array) -> Iterator[GaveWay]:
    """Yield joints, arms apart, whose drives gave nothing for so long that how they usually are shows nothing.

    Args:
        log: the recording.
        time: of servo cycles in which the robot was in balance, shape (cycles,) [s].
        off: how far joints were off their setpoints, shape (cycles, joints) [rad].
        torque: what their drives gave, without its sign, shape (cycles, joints) [Nm].
    """
    robot = log.setup["robot"]
    arms = {joint for joints in robot["arms"].values() for joint in joints}
    for number, (joint, limit) in enumerate(zip(robot["joints"], robot["limits"]["torque"], strict=True)):
        needed = off[:, number] > _OFF
        if not limit or joint in arms or needed.sum() < _IDLE_FOR or torque[:, number].max() > _NOTHING * limit:
            continue
        whole = log.cycles("cycles", -math.inf, float(time[-1]), ["torque"], [joint])
        alive = np.flatnonzero(np.abs(whole.columns["torque"][:, 0]) > _NOTHING * limit)
        began = float(whole.time[alive[-1] if len(alive) else 0])
        angle, given = float(off[:, number].max()), float(torque[:, number].max())
        yield GaveWay(joint, began, float(time[-1]), False, angle, given, limit, dead=True)


def labouring(log: FlightLog, begin: float, end: float) -> str:
    """Return the joint that first was at its torque limit for longer than in a step, arms apart, "" if none was."""
    cycles, robot = log.cycles("cycles", begin, end, ["torque"]), log.setup["robot"]
    arms = {joint for joints in robot["arms"].values() for joint in joints}
    found = []
    for number, (joint, limit) in enumerate(zip(robot["joints"], robot["limits"]["torque"], strict=True)):
        if limit and joint not in arms:
            full = np.abs(cycles.columns["torque"][:, number]) >= FULL * limit
            found += [(first, joint) for first, _ in stretches(full, _LABOURS)]
    return min(found, default=(0, ""))[1]
