"""Pushes that the recording knows of, since a test or a program asked for them."""

from __future__ import annotations

import math
from typing import NamedTuple

from humanoid_bt.review.body import Motion, direction
from humanoid_bt.review.history import History

_JOLT = 0.1  # m/s that a push gives the robot, from which on it may fall of it


class Pushed(NamedTuple):
    """A push that somebody asked for: when [s], how hard, horizontally [N], for how long [s], where to in words."""

    begin: float
    force: float
    duration: float
    direction: str

    def __str__(self) -> str:
        return f"{self.force:.0f} N {self.direction} for {self.duration:g} s, from {self.begin:.3f} s on"


def hardest_push(history: History, motion: Motion, begin: float, end: float) -> Pushed | None:
    """Return the push between two times [s] of which the robot most likely fell, None if there was none.

    One after which it was in balance again is none, nor is one that found it out of balance.
    """
    hardest, most = None, _JOLT * float(history.setup["robot"]["mass"] or 0.0)
    for _, _, (time, kind, value) in history.log.news_of("input"):
        if kind != "push" or not begin <= time < end:
            continue
        _, (x, y, _), duration = value
        force = math.hypot(x, y)
        if not motion.may_explain(time, time + duration):
            continue
        if (impulse := force * min(duration, end - time)) >= most:
            most = impulse
            hardest = Pushed(time, force, duration, direction(math.atan2(y, x) - motion.heading(time)))
    return hardest
