"""How punctual a loop is: a histogram of its lateness, cheap enough for every cycle."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Self

_BIN = 1000  # ns
_BINS = 20_000  # up to 20 ms; later ones count in the last bin


@dataclass(frozen=True)
class Timing:
    """How punctual a loop was.

    Attributes:
        cycles: wake-ups so far.
        missed: wake-ups that were skipped because the one before took too long.
        late_p50, late_p99, late_p999, late_max: lateness of wake-ups [us].
        busy_p50, busy_p99: time from wake-up to the end of the work [us].
        fifo: whether it ran with realtime priority.
    """

    cycles: int = 0
    missed: int = 0
    late_p50: float = 0.0
    late_p99: float = 0.0
    late_p999: float = 0.0
    late_max: float = 0.0
    busy_p50: float = 0.0
    busy_p99: float = 0.0
    fifo: bool = False

    def to_bytes(self) -> bytes:
        """Return it as JSON."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Return what :meth:`to_bytes` made."""
        return cls(**json.loads(data))


class Histogram:
    """Counts durations in bins of a microsecond."""

    def __init__(self) -> None:
        self._bins = [0] * (_BINS + 1)
        self.count = 0
        self.largest = 0

    def add(self, nanoseconds: int) -> None:
        """Count one duration."""
        index = nanoseconds // _BIN
        self._bins[index if index < _BINS else _BINS] += 1
        self.count += 1
        self.largest = max(self.largest, nanoseconds)

    def percentile(self, share: float) -> float:
        """Return the duration [us] below which this share of all lies."""
        wanted, below = share * self.count, 0
        for index, number in enumerate(self._bins):
            below += number
            if number and below >= wanted:
                return index + 0.5
        return 0.0


class Stopwatch:
    """Collects the timing of one loop."""

    def __init__(self, fifo: bool) -> None:
        self._late, self._busy = Histogram(), Histogram()
        self._fifo = fifo
        self.missed = 0

    def note(self, late: int, busy: int, skipped: int) -> None:
        """Count a cycle: how late it woke up [ns], how long it worked [ns], how many were skipped before it."""
        self._late.add(late)
        self._busy.add(busy)
        self.missed += skipped

    @property
    def timing(self) -> Timing:
        """The timing so far."""
        late, busy = self._late, self._busy
        return Timing(
            cycles=late.count,
            missed=self.missed,
            late_p50=late.percentile(0.5),
            late_p99=late.percentile(0.99),
            late_p999=late.percentile(0.999),
            late_max=late.largest / 1000,
            busy_p50=busy.percentile(0.5),
            busy_p99=busy.percentile(0.99),
            fifo=self._fifo,
        )
