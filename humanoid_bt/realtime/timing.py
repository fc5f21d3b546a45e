"""How punctual a loop is: a histogram of its lateness, cheap enough for every cycle."""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import NamedTuple, Self

_BIN = 1000  # ns
_BINS = 20_000  # up to 20 ms; later ones count in the last bin
_WAKE = struct.Struct("<4q")
_LONGEST_TEXT = 600  # characters of a stop's reason and of its source; one takes up to 6 bytes

STOP_ROOM = 20480
"""Bytes that a stop takes at most: its texts, and the paths of five nodes, each of them cut."""


@dataclass(frozen=True)
class Timing:
    """How punctual a loop was.

    Attributes:
        cycles: wake-ups so far.
        missed: wake-ups that were skipped because the one before took too long.
        late_p50, late_p99, late_p999, late_max: lateness of wake-ups [us].
        busy_p50, busy_p99: time from wake-up to the end of the work [us].
        fifo: whether it ran with realtime priority.
        cable: what the cable to the plant was like, "" without one.
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
    cable: str = ""

    def to_bytes(self) -> bytes:
        """Return it as JSON."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Return what :meth:`to_bytes` made."""
        return cls(**json.loads(data))


class Wake(NamedTuple):
    """One wake-up of the servo.

    Attributes:
        woke: when, on the monotonic clock [ns].
        late: how late [ns].
        busy: how long the work took [ns].
        skipped: how many wake-ups before it were skipped.
    """

    woke: int
    late: int
    busy: int
    skipped: int

    @staticmethod
    def pack(woke: int, late: int, busy: int, skipped: int) -> bytes:
        """Return one as bytes, without making it first: this is called in every cycle."""
        return _WAKE.pack(woke, late, busy, skipped)

    @classmethod
    def from_bytes(cls, data: bytes) -> Self:
        """Return what :meth:`pack` made."""
        return cls(*_WAKE.unpack(data))


@dataclass(frozen=True)
class StopRecord:
    """A stop, and when it began.

    Attributes:
        at: monotonic time at which the first setpoint that obeys it had reached the drives [ns].
        time: engine time [s].
        mode: the kind of stop, as :class:`humanoid_bt.core.messages.Mode` has it.
        reason, source: as the supervisor gives them.
        resources: resource -> path of the node of the command in force then.
    """

    at: int
    time: float
    mode: str
    reason: str
    source: str
    resources: Mapping[str, str] = field(default_factory=dict)

    def to_bytes(self) -> bytes:
        """Return it as JSON; long texts are cut."""
        values = asdict(self) | {"reason": self.reason[:_LONGEST_TEXT], "source": self.source[:_LONGEST_TEXT]}
        return json.dumps(values, ensure_ascii=False).encode(errors="replace")

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
        """Return the duration [us] that at least this share of all does not exceed, 0 of none.

        It is the middle of its bin, but never more than the largest.
        """
        wanted, below = share * self.count, 0
        for index, number in enumerate(self._bins):
            below += number
            if number and below >= wanted:
                return min(index + 0.5, self.largest / 1000) if index < _BINS else self.largest / 1000
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
