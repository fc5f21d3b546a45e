"""Pushes that the recording knows of, since a test or a program asked for them."""

from __future__ import annotations

import math
from typing import NamedTuple

from humanoid_bt.review.body import Motion, direction
from humanoid_bt.review.history import History

_JOLT = 0.1  # m/s that a push gives the robot, from which on it may fall of it


class Pushed(NamedTuple):
    """A push that somebody asked for.

    Attributes:
        begin: when [s].
        force: how hard, horizontally [N].
        duration: for how long [s].
        direction: where to, in words, as the robot sees it.
        late: whether balance had been lost before.
    """

    begin: float
    force: float
    duration: float
    direction: str
    late: bool

    @property
    def what(self) -> str:
        """What befell the robot, in words."""
        return f"it was pushed {self.direction} with {self.force:.0f} N at {self.begin:.3f} s"

    def __str__(self) -> str:
        return f"{self.force:.0f} N {self.direction} for {self.duration:g} s, from {self.begin:.3f} s on"


def hardest_push(history: History, motion: Motion, begin: float, end: float) -> Pushed | None:
    """Return the push between two times [s] of which the robot most likely fell, None if there was none.

    One after which it was in balance again is none; one that came after balance was lost is told if no other was.
    """
    found = list[tuple[bool, float, Pushed]]()
    for _, _, (time, kind, value) in history.log.news_of("input"):
        if kind != "push" or not begin <= time < end:
            continue
        _, (x, y, _), duration = value
        force = math.hypot(x, y)
        impulse = force * min(duration, end - time)
        if impulse >= _JOLT * float(history.setup["robot"]["mass"] or 0.0) and motion.may_explain(time + duration):
            words, late = direction(math.atan2(y, x) - motion.heading(time)), motion.is_late(time)
            found.append((not late, impulse, Pushed(time, force, duration, words, late)))
    return max(found)[-1] if found else None
