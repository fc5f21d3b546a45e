"""How punctual a periodic loop was, from a record of its wake-ups."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from humanoid_bt.bench.promises import LATENESS, Verdict
from humanoid_bt.core.clock import SERVO_PERIOD


@dataclass(frozen=True)
class Punctuality:
    """How punctual a loop was during one phase.

    Attributes:
        loop: which loop.
        loaded: whether every core was busy.
        fifo: whether it ran with realtime priority.
        cycles: wake-ups that took place.
        missed: wake-ups that were skipped because the one before took or came too long.
        late_p50, late_p99, late_p999, late_max: lateness [us].
        jitter_p50, jitter_p99: how far the time between two wake-ups is from the period [us].
    """

    loop: str
    loaded: bool
    fifo: bool
    cycles: int
    missed: int
    late_p50: float
    late_p99: float
    late_p999: float
    late_max: float
    jitter_p50: float
    jitter_p99: float

    @property
    def verdict(self) -> Verdict | None:
        """Whether a servo kept its promise; None without realtime priority, for which nothing is promised."""
        return LATENESS.verdict(self.late_p99) if self.fifo else None


def percentile(values: ArrayLike, share: float) -> float:
    """Return the smallest value that at least this share of all does not exceed (nearest rank); 0 of none."""
    array: NDArray[np.float64] = np.asarray(values, dtype=np.float64)
    return float(np.quantile(array, share, method="inverted_cdf")) if array.size else 0.0


def punctuality(
    loop: str, *, loaded: bool, fifo: bool, woke: ArrayLike, late: ArrayLike, skipped: ArrayLike
) -> Punctuality:
    """Return how punctual a loop with the servo's period was.

    Args:
        loop: its name.
        loaded: whether every core was busy.
        fifo: whether it ran with realtime priority.
        woke: when each wake-up was [ns], shape (n,).
        late: how late it was [ns], shape (n,).
        skipped: how many before it were skipped, shape (n,).
    """
    late_us = np.asarray(late, dtype=np.float64) / 1e3
    woke_ns: NDArray[np.int64] = np.asarray(woke, dtype=np.int64)
    jitter = np.abs(woke_ns[1:] - woke_ns[:-1] - round(SERVO_PERIOD * 1e9)) / 1e3
    return Punctuality(
        loop,
        loaded,
        fifo,
        cycles=int(late_us.size),
        missed=int(np.sum(skipped)),
        late_p50=percentile(late_us, 0.5),
        late_p99=percentile(late_us, 0.99),
        late_p999=percentile(late_us, 0.999),
        late_max=float(late_us.max(initial=0.0)),
        jitter_p50=percentile(jitter, 0.5),
        jitter_p99=percentile(jitter, 0.99),
    )
