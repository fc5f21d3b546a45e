"""What led up to a moment: nodes, events, joints, gait and modes on one short list."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from humanoid_bt.core.units import readable
from humanoid_bt.record.reading import AT
from humanoid_bt.review.body import Motion
from humanoid_bt.review.explanation import Moment
from humanoid_bt.review.history import OVER, History
from humanoid_bt.review.words import changed, cut

_LEANS = 0.2  # rad of tilt that no robot that walks has
_Ranked = tuple[int, Moment]  # how much a line matters, 0 the most


def before(history: History, begin: float, end: float) -> list[Moment]:
    """Return what happened between two times [s], what matters most first, of that the latest."""
    ranked = [*_told(history, begin, end), *_measured(history, begin, end)]
    return [moment for _, moment in sorted(ranked, key=lambda item: (item[0], -item[1].time))]


def chosen(moments: list[Moment], most: int) -> list[Moment]:
    """Return so many of the moments that matter most, in the order of time, and how many are left out."""
    kept = sorted(moments[:most])
    if left := len(moments) - len(kept):
        kept.append(Moment(kept[-1].time, f"... and {left} more: nodes over time, and events, in the viewer"))
    return kept


def _told(history: History, begin: float, end: float) -> Iterator[_Ranked]:
    for change in history.changes:
        if begin - AT <= change.time <= end + AT and change.said and change.said != OVER:  # no news
            kind = history.kind(change.path, change.time).get("kind", "")
            yield {"skill": 1, "condition": 1}.get(kind, 2), Moment(change.time, changed(change))
    for event in history.events:
        if begin - AT <= event.time <= end + AT and not event.text.startswith("the tree ended"):
            yield int(event.level == "info"), Moment(event.time, f"• {_short(event.text)}")


def _short(text: str) -> str:
    """Return an event without what it says a person can do."""
    return cut(text.partition("; waiting for a reset")[0].removesuffix(" (supervisor)"))


def _measured(history: History, begin: float, end: float) -> Iterator[_Ranked]:
    motion = Motion(history.log, begin, end)
    if not len(motion.time):
        return
    for limited in motion.limited()[:4]:
        yield 1 if limited.what == "torque" else 3, Moment(limited.begin, str(limited))
    leaning = np.flatnonzero(motion.tilt > _LEANS)
    if len(leaning) and leaning[0] > 0:
        yield 0, Moment(float(motion.time[leaning[0]]), f"the base tilts by more than {readable(_LEANS, 'rad')}")
    plans = history.log.cycles("plans", begin, end, ["plan"])
    gaits = plans.columns["plan"][:, 1].astype(int)
    for place in (np.flatnonzero(np.diff(gaits)) + 1)[:3]:
        yield 3, Moment(float(plans.time[place]), f"gait {history.log.layout['gaits'][gaits[place]]}")
