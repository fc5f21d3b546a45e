"""What the numbers of the servo cycles show of the body: joints at limits, pushes, how far it leaned."""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.messages import Array
from humanoid_bt.core.units import readable
from humanoid_bt.record.reading import FlightLog

FULL = 0.99
"""Share of a joint's torque limit from which on it has no more to give."""

_LONG = 20  # servo cycles that a joint must be at its torque limit to count
_WINDOW = 100  # servo cycles over which an acceleration is taken: a step's impact is shorter
_FINE = 20  # servo cycles over which its begin is looked for
_PUSH = 3.0  # m/s^2 that nobody takes for a step
_TIMES = 2.0  # as much as the largest of the run before is a push
_BEGUN = 0.5  # share of a push's largest acceleration at which it has begun: the blows of steps before it are less
_PLANS = 2  # in which a setpoint is clamped at least: where references change, as at a run's end, a single one may be
_KNOWN = 250  # servo cycles that must have gone before a push, to know what steps do
_FROM_PUSH = 1.0  # s before balance was lost in which a push must have been to explain it
_SLIPS = 0.05  # rad of tilt in which a push finds no robot that walks, but one that slips is before its base jerks
_STEADY = 0.08  # rad of tilt that a robot in balance stays below
_SETTLED = 500  # servo cycles for which it must stay so to be in balance
_UPRIGHT = 0.35  # rad of tilt up to which gravity alone accelerates less than that
_SIDEWAYS = 0.5  # share of a direction from which on it is named


class Limited(NamedTuple):
    """A joint was at its limit.

    Attributes:
        joint: its name.
        what: "torque" for what the drive gave, "setpoint" for a setpoint that was clamped.
        begin, end: first and last time [s].
        duration: how long in all [s].
        value, limit: largest torque and its limit [Nm]; 0 for a setpoint.
    """

    joint: str
    what: str
    begin: float
    end: float
    duration: float
    value: float
    limit: float

    def __str__(self) -> str:
        if self.what == "setpoint":
            return f"setpoints of {self.joint} were clamped for {readable(self.duration, 's')}"
        return f"{self.joint} at its torque limit: {self.value:.1f} of {self.limit:g} Nm for {self.duration:.2f} s"


class Push(NamedTuple):
    """The base was accelerated as no command asked for.

    Attributes:
        begin, end: when [s].
        acceleration: horizontal, on average [m/s^2].
        before: the largest of the run before it [m/s^2].
        direction: in words, as the robot sees it.
    """

    begin: float
    end: float
    acceleration: float
    before: float
    direction: str

    def __str__(self) -> str:
        return (
            f"base accelerated {self.direction} by {self.acceleration:.1f} m/s², {self.begin:.3f} to "
            f"{self.end:.3f} s; before that by at most {self.before:.1f}"
        )


class Motion:
    """How the body moved between two times.

    Args:
        log: the recording.
        begin, end: engine times [s].

    Attributes:
        time: of each servo cycle, shape (cycles,) [s].
        tilt: of the base, shape (cycles,) [rad].
        height: of the base, shape (cycles,) [m].
        speed: horizontal, of the base, shape (cycles,) [m/s].
    """

    def __init__(self, log: FlightLog, begin: float, end: float) -> None:
        self._log, self._begin, self._end = log, begin, end
        names = ["base_position", "base_quaternion", "base_velocity", "torque", "foot_force"]
        cycles = log.cycles("cycles", begin, end, names)
        self.time, columns = cycles.time, cycles.columns
        w, x, y, z = columns["base_quaternion"].T
        self.tilt: Array = np.arccos(np.clip(1 - 2 * (x * x + y * y), -1, 1))
        self._yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
        self.height = columns["base_position"][:, 2]
        self._velocity = columns["base_velocity"][:, :2]
        self.speed: Array = np.linalg.norm(self._velocity, axis=1)
        self._torque, self.foot_force = columns["torque"], columns["foot_force"]

    def heading(self, time: float) -> float:
        """Return where the base headed at a time [rad]."""
        return float(self._yaw[self._cycle(time)])

    def leaning(self, time: float) -> float:
        """Return how far the base was tilted at a time [rad]."""
        return float(self.tilt[self._cycle(time)])

    def _cycle(self, time: float) -> int:
        return int(self.time.searchsorted(time).clip(0, len(self.time) - 1))

    @cached_property
    def settled(self) -> list[tuple[int, int]]:
        """Where it was in balance for a while: the first servo cycle, and the one after the last."""
        return stretches(self.tilt < _STEADY, _SETTLED)

    @cached_property
    def lost(self) -> float:
        """When balance was lost that had been in order for a while; the first time if it never was [s]."""
        return float(self.time[self.settled[-1][1] - 1 if self.settled else 0])

    def is_late(self, time: float) -> bool:
        """Return whether balance had been lost by a time [s]; nobody knows when if the robot never was in it."""
        return bool(self.settled) and time > self.lost

    def may_explain(self, time: float) -> bool:
        """Return whether what ended at a time [s] was near enough to the loss of balance to be its reason."""
        return time >= self.lost - _FROM_PUSH

    def limited(self) -> list[Limited]:
        """Return the joints that were at their torque limit, or else whose setpoints were clamped, in order of time."""
        full = self._at_torque_limit()
        named = {limited.joint for limited in full}
        others = [limited for limited in clamped(self._log, self._begin, self._end) if limited.joint not in named]
        return sorted([*full, *others], key=lambda limited: limited.begin)

    def _at_torque_limit(self) -> list[Limited]:
        robot, found = self._log.setup["robot"], []
        for number, (joint, limit) in enumerate(zip(robot["joints"], robot["limits"]["torque"], strict=True)):
            if limit is None:
                continue
            torque = np.abs(self._torque[:, number])
            at = np.flatnonzero(torque >= FULL * limit)
            if len(at) >= _LONG:
                first, last = float(self.time[at[0]]), float(self.time[at[-1]])
                found.append(Limited(joint, "torque", first, last, len(at) * 1e-3, float(torque.max()), limit))
        return found

    def push(self) -> Push | None:
        """Return the acceleration of the base that made it lose balance, and is no step; None if there is none."""
        if len(self.time) <= _KNOWN + 2 * _WINDOW:
            return None
        coarse = self._acceleration(_WINDOW)
        strength = np.linalg.norm(coarse, axis=1)
        before = np.maximum.accumulate(strength)
        known = np.full(len(before), np.inf)
        known[_KNOWN + _WINDOW :] = before[_KNOWN:-_WINDOW]  # what ended before it began
        time, tilt = self.time[: len(strength)], self.tilt[: len(strength)]
        near = (time > self.lost - _FROM_PUSH) & (time < self.lost) & (tilt < _UPRIGHT)
        sudden = near & (strength > np.maximum(_PUSH, _TIMES * known))
        if not sudden.any():
            return None
        seed = int(np.argmax(sudden))
        fine = np.linalg.norm(self._acceleration(_FINE), axis=1)
        strong = fine[seed : seed + 2 * _WINDOW] > _BEGUN * strength[seed : seed + 2 * _WINDOW].max()
        after = np.flatnonzero(strong)
        if not len(after):
            return None
        first = seed + int(after[0]) + _FINE // 2
        peak = first + int(np.argmax(strength[first : first + 2 * _WINDOW])) if first < len(strength) else first
        end = min(peak + _WINDOW, len(self.time) - 1)
        change = (self._velocity[end] - self._velocity[first]) / max(self.time[end] - self.time[first], 1e-3)
        largest = float(known[seed])
        acceleration = float(np.linalg.norm(change))
        if acceleration <= max(_PUSH, largest) or self.tilt[first] > _SLIPS:
            return None
        words = direction(math.atan2(change[1], change[0]) - float(self._yaw[first]))
        return Push(float(self.time[first]), float(self.time[end]), acceleration, largest, words)

    def _acceleration(self, window: int) -> Array:
        """Return the horizontal acceleration of the base over the next so many servo cycles [m/s^2]."""
        return (self._velocity[window:] - self._velocity[:-window]) / (window * 1e-3)


def stretches(flags: NDArray[np.bool_], least: int) -> list[tuple[int, int]]:
    """Return where flags are set for so many places or more at a stretch: the first, and the one after the last."""
    edges = np.flatnonzero(np.diff(flags, prepend=False, append=False))
    return [(int(first), int(after)) for first, after in edges.reshape(-1, 2) if after - first >= least]


def clamped(log: FlightLog, begin: float = -math.inf, end: float = math.inf) -> list[Limited]:
    """Return the joints whose setpoints were clamped between two times [s]: soft limit, speed, feedforward torque."""
    plans = log.cycles("plans", begin, end, ["limited"])
    limited = plans.columns["limited"] > 0.5
    period = float(np.median(np.diff(plans.time))) if len(plans.time) > 1 else 0.005
    found = []
    for number in np.flatnonzero(limited.any(axis=0)):
        at = np.flatnonzero(limited[:, number])
        if len(at) < _PLANS:
            continue
        joint = plans.described["limited"].labels[number]
        first, last = float(plans.time[at[0]]), float(plans.time[at[-1]])
        found.append(Limited(joint, "setpoint", first, last, len(at) * period, 0.0, 0.0))
    return found


def direction(angle: float) -> str:
    """Return the direction of an angle from straight ahead [rad] in words."""
    ahead, left = math.cos(angle), math.sin(angle)
    words = ["forward" if ahead > 0 else "backward"] if abs(ahead) >= _SIDEWAYS else []
    words += ["to the left" if left > 0 else "to the right"] if abs(left) >= _SIDEWAYS else []
    return " and ".join(words)
