"""What decision knows of the supervisor and the clock in the control process."""

from __future__ import annotations

import threading
from collections import deque

from humanoid_bt.control.supervisor import Stop
from humanoid_bt.core.kept import Kept
from humanoid_bt.core.messages import Mode
from humanoid_bt.link.estop import EStop
from humanoid_bt.realtime.timing import StopRecord

_MOST = 1000  # stops, and refusals, that are kept


class StateClock:
    """The engine's clock as decision knows it: the time of the state that the tick sees."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        """Return the engine's time [s]."""
        return self.time


class RemoteSupervisor:
    """What decision knows of the supervisor in the control process.

    The e-stop may be raised and a reset asked for from any thread: a key must work while a tick hangs.

    Attributes:
        stops: the stops so far; of very many the first and the latest.
        rejected: commands that were refused so far, as text; as of stops.
    """

    def __init__(self) -> None:
        self.stops: Kept[Stop] = Kept(_MOST)
        self.rejected: Kept[str] = Kept(_MOST)
        self._pending: deque[tuple[str, str]] = deque()
        self._estop: EStop | None = None
        self._early: list[tuple[str, str]] = []  # raised before the run began
        self._lock = threading.Lock()

    def connect(self, estop: EStop) -> None:
        """Take decision's end of the e-stop."""
        with self._lock:
            self._estop = estop
            for source, reason in self._early:
                estop.raise_(source, reason)
            self._early.clear()

    def disconnect(self) -> None:
        """Let go of the e-stop: the robot is gone."""
        with self._lock:
            estop, self._estop = self._estop, None
            if estop is not None:
                estop.close()

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop."""
        with self._lock:
            if self._estop is None:
                self._early.append((source, reason))
            else:
                self._estop.raise_(source, reason)

    def request_reset(self, source: str) -> None:
        """Ask control for a reset; its answer comes as a notice."""
        with self._lock:
            if self._estop is not None:
                self._estop.request_reset(source)

    def request_stop(self, source: str, reason: str) -> None:
        """Ask for a protective stop until the end of the run."""
        self._pending.append((source, reason))

    def take_requests(self) -> list[tuple[str, str]]:
        """Return the requests that control does not know yet."""
        taken = list(self._pending)
        self._pending.clear()
        return taken

    def note(self, stop: StopRecord) -> None:
        """Take a stop that control has made."""
        self.stops.append(Stop(stop.time, Mode(stop.mode), stop.reason, stop.source, stop.resources))
