"""Simulated time, held back to a pace for those who watch."""

from __future__ import annotations

import time

_LATE = 0.5  # s behind the pace that are caught up; what a longer pause took is not


class Pace:
    """Holds simulated time back.

    Args:
        speed: simulated seconds per second; None for as fast as it can.
    """

    def __init__(self, speed: float | None) -> None:
        self.speed = speed
        self._began: float | None = None  # when time zero was, or would have been

    def keep(self, now: float) -> None:
        """Sleep until an engine time [s] is due."""
        if not self.speed:
            return
        due = now / self.speed
        if self._began is None:
            self._began = time.monotonic() - due
        ahead = due - (time.monotonic() - self._began)
        if ahead > 0:
            time.sleep(ahead)
        elif ahead < -_LATE:
            self._began -= ahead
