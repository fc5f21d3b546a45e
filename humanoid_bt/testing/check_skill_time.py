"""Real time while a skill is tried: ticks that last too long, and who reads the wall clock."""

from __future__ import annotations

import datetime
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from humanoid_bt.core.errors import Place, relative

_CLOCKS = frozenset(
    getattr(time, f"{name}{unit}") for name in ("time", "monotonic", "perf_counter") for unit in ("", "_ns")
)
_DATES = (datetime.datetime, datetime.date)


class TooLong(BaseException):
    """A tick lasted too long; not an ``Exception``, which a skill may catch."""


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Raise :class:`TooLong` where the program is when a time [s] is over; only the main thread can be interrupted."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def ring(_number: int, _frame: FrameType | None) -> None:
        raise TooLong(f"after {seconds:g} s")

    handler = signal.signal(signal.SIGALRM, ring)
    others = signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, *others)
        signal.signal(signal.SIGALRM, handler or signal.SIG_DFL)


@contextmanager
def clocks_read(folder: Path) -> Iterator[dict[str, Place]]:
    """Note which wall clocks the code of a folder reads meanwhile, and where: ``time.monotonic`` -> its place."""
    found: dict[str, Place] = {}
    inside = f"{folder}/"

    def called(frame: FrameType, event: str, function: Any) -> None:
        if event == "c_call" and frame.f_code.co_filename.startswith(inside):
            name = _clock(function)
            if name and name not in found:
                found[name] = Place(relative(Path(frame.f_code.co_filename)), frame.f_lineno, 1)

    before = sys.getprofile()
    sys.setprofile(called)
    try:
        yield found
    finally:
        sys.setprofile(before)


def _clock(function: Any) -> str:
    """Return the name of a function if it reads the wall clock, else ""."""
    if function in _CLOCKS:
        return f"time.{function.__name__}"
    of: Any = getattr(function, "__self__", None)
    if any(of is date for date in _DATES) and function.__name__ in ("now", "utcnow", "today"):
        return f"{of.__name__}.{function.__name__}"
    return ""
