"""The flight log: every servo cycle, every tick and everything that happened, in the recording and exact.

The viewer has no use for a thousand samples a second of a hundred numbers; it shows those of the ticks, in pictures and
plots. What is here is for whoever wants to know what happened, or to run it again: see
:class:`~humanoid_bt.record.reading.FlightLog`.
"""

from __future__ import annotations

import json
import math
import threading
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import rerun as rr

from humanoid_bt.control.cycle_log import GAITS, MODES, Layout, Row
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.messages import Array
from humanoid_bt.link.table import TableReader
from humanoid_bt.record.columns import send
from humanoid_bt.record.packing import bundle, pack

FLIGHT = "flight"
PLANS, CYCLES, TICKS, NEWS = "plans", "cycles", "ticks", "news"
_LOOK = 0.02  # s between two looks into tables that are files
_APART = 10.0  # s between losses that are told one by one


class Flight:
    """Collects what is to be kept and writes it in batches.

    Args:
        joints: the robot's joints.
        setup: what is run, as data for JSON.
    """

    def __init__(self, joints: tuple[str, ...], setup: Mapping[str, Any]) -> None:
        self._layout, self._setup = Layout.of(joints), setup
        self._rows: dict[str, deque[Array]] = {PLANS: deque(), CYCLES: deque()}
        self._kinds = {PLANS: self._layout.plan, CYCLES: self._layout.cycle}
        self._ticks, self._news = list[bytes](), list[bytes]()
        self._until = 0.0  # engine time of the last that was taken [s]
        self._follower: _Follower | None = None

    def log_static(self, stream: Any) -> None:
        """Write what was run, and what the rows hold."""
        layout = {
            "modes": [mode.value for mode in MODES],
            "gaits": [gait.value for gait in GAITS],
            PLANS: _described(self._layout.plan),
            CYCLES: _described(self._layout.cycle),
        }
        values = rr.AnyValues(layout=[json.dumps(layout)], setup=[json.dumps(self._setup)])
        stream.log(FLIGHT, values, static=True)

    def add(self, plans: Array, cycles: Array) -> None:
        """Take rows of plans and servo cycles, in the order of time."""
        self._rows[PLANS].append(plans)
        self._rows[CYCLES].append(cycles)

    def tick(self, time: float, tick: bytes) -> None:
        """Take a tick [s], encoded."""
        self._until = time
        self._ticks.append(tick)

    def news(self, time: float, kind: str, value: Any) -> None:
        """Take something that happened.

        Args:
            time: engine time [s].
            kind: what it is.
            value: data for JSON.
        """
        self._until = max(self._until, time)
        self._news.append(json.dumps([time, kind, value]).encode())

    def follow(self, plans: Path, cycles: Path) -> None:
        """Take rows from these tables from now on, by itself.

        Raises:
            LinkError: they are not there.
        """
        self._follower = _Follower(self, TableReader.open(plans), TableReader.open(cycles))
        self._follower.start()

    @property
    def follows(self) -> bool:
        """Whether it takes rows by itself."""
        return self._follower is not None

    @property
    def control_lives(self) -> bool:
        """Whether it takes rows by itself from somebody who still writes them."""
        return self._follower is not None and self._follower.control_lives

    def finish(self, patience: float, stream: Any) -> None:
        """Take what control still writes, until it has ended or it takes too long [s]; write it as it comes."""
        if self._follower is not None:
            for _ in self._follower.finish(patience):
                self.flush(stream)

    @property
    def trouble(self) -> str:
        """What was missing last, "" while nothing is."""
        return self._follower.trouble if self._follower is not None else ""

    def flush(self, stream: Any) -> bool:
        """Write what was added since the last flush; return whether there was anything."""
        blocks = {}
        for name, waiting in self._rows.items():
            parts = [waiting.popleft() for _ in range(len(waiting))]  # others may come meanwhile
            rows = np.concatenate(parts) if parts else np.zeros((0, 0))
            if len(rows):
                blocks[name] = pack(rows, self._kinds[name].resolution)
                self._until = max(self._until, float(rows[-1, 0]) * SERVO_PERIOD)
        for name, messages in ((TICKS, self._ticks), (NEWS, self._news)):
            if messages:
                blocks[name] = bundle(messages)
                messages.clear()
        if blocks:
            columns = {name: pa.array([block], type=pa.binary()) for name, block in blocks.items()}
            send(stream, FLIGHT, [self._until], rr.AnyValues.columns(**columns))
        return bool(blocks)


class _Follower(threading.Thread):
    """Takes rows from control's tables, whatever decision does."""

    def __init__(self, flight: Flight, plans: TableReader, cycles: TableReader) -> None:
        super().__init__(name="flight", daemon=True)
        self._flight, self._plans, self._cycles = flight, plans, cycles
        self._read = [0, 0]
        self._ending = threading.Event()
        self._lost = -math.inf  # engine time before which the last ones were lost [s]
        self.trouble = ""

    @property
    def control_lives(self) -> bool:
        """Whether somebody still writes the rows."""
        return self._cycles.has_writer

    def run(self) -> None:
        """Take rows until it is to finish."""
        while not self._ending.wait(_LOOK):
            self._take()

    def finish(self, patience: float) -> Iterator[None]:
        """Take what comes until control has ended, or it takes too long [s]."""
        self._ending.set()
        self.join()
        waits = threading.Event()
        for _ in range(round(patience / _LOOK)):
            if not self.control_lives:
                break
            waits.wait(_LOOK)
            self._take()
            yield
        self._take()
        yield

    def _take(self) -> None:
        (plans, lost_plans), (cycles, lost) = self._plans.since(self._read[0]), self._cycles.since(self._read[1])
        until = (self._read[1] + lost) * SERVO_PERIOD  # there may be no row left after those
        self._read = [self._read[0] + lost_plans + len(plans), self._read[1] + lost + len(cycles)]
        if lost:
            if until - self._lost > _APART:
                self.trouble = (
                    f"servo cycles are missing in the recording before {until:.2f} s: they were taken too late"
                )
            self._lost = until
        self._flight.add(plans, cycles)


def _described(row: Row) -> list[dict[str, Any]]:
    return [asdict(column) for column in row.columns]
