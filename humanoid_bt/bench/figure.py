"""One measurement beside its baseline, and the arithmetic of it."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

Pairs = list[tuple[float, float]]
"""What we took and what the baseline took, once per repetition."""


@dataclass(frozen=True)
class Figure:
    """One measurement.

    Attributes:
        name: what was measured.
        baseline: what it is compared with.
        ours, theirs: median of the repetitions, in ``unit``.
        ratio: median of ours / theirs, pair by pair.
        low, high: smallest and largest ratio.
        must, aim: bounds of the ratio, for people; None where there are none.
        more_is_better: whether the bounds are lower bounds.
    """

    name: str
    baseline: str
    unit: str
    ours: float
    theirs: float
    ratio: float
    low: float
    high: float
    must: float | None = None
    aim: float | None = None
    more_is_better: bool = False

    @property
    def must_text(self) -> str:
        """The bound that has to hold, as text."""
        return self._bound(self.must)

    @property
    def aim_text(self) -> str:
        """The bound that is aimed at, as text."""
        return self._bound(self.aim)

    def _bound(self, value: float | None) -> str:
        return "" if value is None else f"{'>=' if self.more_is_better else '<='} {value:g}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return asdict(self)


def cpu(function: Callable[[], object], calls: int = 1) -> float:
    """Return the CPU time [s] that a call takes, on average over ``calls``."""
    begin = time.process_time()
    for _ in range(calls):
        function()
    return (time.process_time() - begin) / calls


def in_turn(repetitions: int, ours: Callable[[], float], theirs: Callable[[], float]) -> Pairs:
    """Measure the two in turn; the first pair warms up and does not count."""
    return [(ours(), theirs()) for _ in range(repetitions + 1)][1:]


def figure(
    name: str,
    baseline: str,
    unit: str,
    pairs: Pairs,
    *,
    scale: float = 1.0,
    must: float | None = None,
    aim: float | None = None,
    more_is_better: bool = False,
) -> Figure:
    """Return the figure of some pairs.

    Args:
        name: what was measured.
        baseline: what it is compared with.
        unit: of what is shown.
        pairs: at least one.
        scale: from the pairs' unit to ``unit``.
        must: bound of the ratio that has to hold.
        aim: bound of the ratio that is aimed at.
        more_is_better: whether the bounds are lower bounds.
    """
    ratios = [ours / theirs for ours, theirs in pairs]
    return Figure(
        name,
        baseline,
        unit,
        scale * statistics.median(ours for ours, _ in pairs),
        scale * statistics.median(theirs for _, theirs in pairs),
        statistics.median(ratios),
        min(ratios),
        max(ratios),
        must,
        aim,
        more_is_better,
    )
