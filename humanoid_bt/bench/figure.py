"""One measurement beside its baseline, and the arithmetic of it."""

from __future__ import annotations

import resource
import statistics
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from humanoid_bt.bench.promises import Promise, Verdict

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
        promise: the bound of the ratio, or of ``ours`` if it has another unit than "x"; None where there is none.
    """

    name: str
    baseline: str
    unit: str
    ours: float
    theirs: float
    ratio: float
    low: float
    high: float
    promise: Promise | None = None

    @property
    def verdict(self) -> Verdict | None:
        """Whether it keeps its promise, None without one."""
        if self.promise is None:
            return None
        return self.promise.verdict(self.ratio if self.promise.unit == "x" else self.ours)

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {**asdict(self), "verdict": self.verdict}


def cpu(function: Callable[[], object], calls: int = 1) -> float:
    """Return the CPU time [s] of a call, on average over ``calls``, with that of processes it starts and ends."""
    begin = _spent()
    for _ in range(calls):
        function()
    return (_spent() - begin) / calls


def _spent() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


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
    promise: Promise | None = None,
) -> Figure:
    """Return the figure of some pairs.

    Args:
        name: what was measured.
        baseline: what it is compared with.
        unit: of what is shown.
        pairs: at least one.
        scale: from the pairs' unit to ``unit``.
        promise: the bound of the ratio, or of what we took if it has another unit than "x".
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
        promise,
    )
