"""Every servo cycle in the recording: rows of plans and of servo cycles, packed into blocks.

The viewer has no use for a thousand samples a second of a hundred numbers; it shows those of the ticks. These are for
whoever wants to know what happened between two ticks: :func:`~humanoid_bt.record.reading.read_cycles`.
"""

from __future__ import annotations

import json
import threading
from collections import deque
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
from humanoid_bt.record.packing import pack

FLIGHT = "flight"
PLANS, CYCLES = f"{FLIGHT}/plans", f"{FLIGHT}/cycles"
_LOOK = 0.2  # s between two looks into tables that are files


class Flight:
    """Collects rows and writes them in batches.

    Args:
        joints: the robot's joints.
    """

    def __init__(self, joints: tuple[str, ...]) -> None:
        self._layout = Layout.of(joints)
        self._rows: dict[str, deque[Array]] = {PLANS: deque(), CYCLES: deque()}
        self._kinds = {PLANS: self._layout.plan, CYCLES: self._layout.cycle}
        self._follower: _Follower | None = None

    def log_static(self, stream: Any) -> None:
        """Write what the rows hold."""
        described = {
            "modes": [mode.value for mode in MODES],
            "gaits": [gait.value for gait in GAITS],
            "plans": _described(self._layout.plan),
            "cycles": _described(self._layout.cycle),
        }
        stream.log(FLIGHT, rr.AnyValues(layout=[json.dumps(described)]), static=True)

    def add(self, plans: Array, cycles: Array) -> None:
        """Take rows, in the order of time."""
        self._rows[PLANS].append(plans)
        self._rows[CYCLES].append(cycles)

    def follow(self, plans: Path, cycles: Path) -> None:
        """Take rows from these tables from now on, by itself.

        Raises:
            LinkError: they are not there.
        """
        self._follower = _Follower(self, TableReader.open(plans), TableReader.open(cycles))
        self._follower.start()

    def finish(self, patience: float) -> None:
        """Take what control still writes, until it has ended or it takes too long [s]."""
        if self._follower is not None:
            self._follower.finish(patience)

    @property
    def trouble(self) -> str:
        """What is missing, "" while nothing is."""
        return self._follower.trouble if self._follower is not None else ""

    def flush(self, stream: Any) -> None:
        """Write what was added since the last flush."""
        for path, waiting in self._rows.items():
            parts = [waiting.popleft() for _ in range(len(waiting))]  # others may come meanwhile
            rows = np.concatenate(parts) if parts else np.zeros((0, 0))
            if len(rows):
                block = pack(rows, self._kinds[path].resolution)
                columns = rr.AnyValues.columns(block=pa.array([block], type=pa.binary()))
                send(stream, path, [float(rows[-1, 0]) * SERVO_PERIOD], columns)


class _Follower(threading.Thread):
    """Takes rows from control's tables, whatever decision does."""

    def __init__(self, flight: Flight, plans: TableReader, cycles: TableReader) -> None:
        super().__init__(name="flight", daemon=True)
        self._flight, self._plans, self._cycles = flight, plans, cycles
        self._read = [0, 0]
        self._ending = threading.Event()
        self.trouble = ""

    def run(self) -> None:
        """Take rows until it is to finish."""
        while not self._ending.wait(_LOOK):
            self._take()

    def finish(self, patience: float) -> None:
        """Take what comes until control has ended, or it takes too long [s]."""
        self._ending.set()
        self.join()
        waits = threading.Event()
        for _ in range(round(patience / _LOOK)):
            if not self._cycles.has_writer:
                break
            waits.wait(_LOOK)
            self._take()
        self._take()

    def _take(self) -> None:
        (plans, lost_plans), (cycles, lost) = self._plans.since(self._read[0]), self._cycles.since(self._read[1])
        until = (self._read[1] + lost) * SERVO_PERIOD  # there may be no row left after those
        self._read = [self._read[0] + lost_plans + len(plans), self._read[1] + lost + len(cycles)]
        if lost and not self.trouble:
            self.trouble = f"servo cycles are missing in the recording before {until:.2f} s: they were taken too late"
        self._flight.add(plans, cycles)


def _described(row: Row) -> list[dict[str, Any]]:
    return [asdict(column) for column in row.columns]
