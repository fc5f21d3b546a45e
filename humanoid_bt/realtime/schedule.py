"""Keeping a period on the wall clock: absolute wake-ups, realtime priority where the system allows it."""

from __future__ import annotations

import ctypes
import gc
import os
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field

_NANO = 1_000_000_000
_CLOCK_MONOTONIC, _TIMER_ABSTIME = 1, 1
_LOCK_CURRENT_AND_FUTURE = 3  # MCL_CURRENT | MCL_FUTURE
_SET_TIMER_SLACK = 29  # PR_SET_TIMERSLACK
_PRIORITY = 80  # of 1-99 for SCHED_FIFO; above everything but the kernel's own threads

SPIN = 100_000
"""Time before a wake-up that is spent spinning, because a sleep ends late [ns]."""

FIFO_HINT = "allow it with 'ulimit -r 80' (or rtprio in limits.conf), or give the interpreter CAP_SYS_NICE"


class _Timespec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))


@dataclass(frozen=True)
class Privileges:
    """What the system allowed.

    Attributes:
        fifo: the process runs with realtime priority.
        locked: its memory stays in RAM.
        core: the processor it is pinned to, None if it is not.
        warnings: what was refused, and what to do about it.
    """

    fifo: bool = False
    locked: bool = False
    core: int | None = None
    warnings: tuple[str, ...] = field(default=())


def claim(core: int | None = None) -> Privileges:
    """Ask the system for everything that keeps this process punctual; take what it gives.

    Args:
        core: processor to pin the process to; None to let it move.
    """
    gc.collect()
    gc.freeze()
    gc.disable()
    if not sys.platform.startswith("linux"):
        return Privileges(warnings=("no realtime priority on this system: expect wake-ups late by a millisecond",))
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_SET_TIMER_SLACK, 1, 0, 0, 0)
    locked = libc.mlockall(_LOCK_CURRENT_AND_FUTURE) == 0
    pinned = None
    if core is not None:
        try:
            os.sched_setaffinity(0, {core})
            pinned = core
        except OSError:
            pinned = None
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    except OSError:
        warning = f"no realtime priority: wake-ups may be late by a millisecond; {FIFO_HINT}"
        return Privileges(False, locked, pinned, (warning,))
    return Privileges(True, locked, pinned)


def last_core() -> int | None:
    """Return the processor farthest from the one that serves most interrupts, None if there is only one."""
    if not hasattr(os, "sched_getaffinity"):
        return None
    cores = sorted(os.sched_getaffinity(0))
    return cores[-1] if len(cores) > 1 else None


class Schedule:
    """Wake-ups at a fixed period; those that were missed are skipped and counted, never caught up.

    Args:
        period: [s].
        spin: end each wait by spinning. Only with realtime priority: without it, spinning costs more than it gains.
        now: returns the time [ns]; the monotonic clock if not given.
        sleep_until: sleeps until such a time, or a little longer.

    Attributes:
        missed: wake-ups that were skipped so far.
    """

    def __init__(
        self,
        period: float,
        spin: bool,
        now: Callable[[], int] = time.monotonic_ns,
        sleep_until: Callable[[int], None] | None = None,
    ) -> None:
        self._period = round(period * _NANO)
        self._spin = SPIN if spin else 0
        self._now, self._sleep_until = now, sleep_until or _absolute_sleep()
        self._next = now() + self._period
        self.missed = 0

    def wait(self) -> tuple[int, int]:
        """Sleep until the next wake-up.

        Returns:
            How late it was [ns], and how many wake-ups before it were skipped.
        """
        clock = self._now
        now = clock()
        skipped = self._skip(now)
        due = self._next
        while now < due - self._spin:  # again if a signal ended the sleep early
            self._sleep_until(due - self._spin)
            now = clock()
        while now < due:
            now = clock()
        skipped += self._skip(now)  # it may have overslept
        self._next += self._period
        return now - due, skipped

    def _skip(self, now: int) -> int:
        """Skip the wake-ups that are over at a time [ns] but the last of them; return how many."""
        skipped = max((now - self._next) // self._period, 0)
        self._next += skipped * self._period
        self.missed += skipped
        return skipped


def _absolute_sleep() -> Callable[[int], None]:
    """Return a function that sleeps until a time of the monotonic clock [ns]."""
    if sys.platform.startswith("linux"):
        libc = ctypes.CDLL(None, use_errno=True)
        nanosleep = libc.clock_nanosleep
        until = _Timespec()
        reference = ctypes.byref(until)

        def sleep(due: int) -> None:
            until.seconds, until.nanoseconds = divmod(due, _NANO)
            nanosleep(_CLOCK_MONOTONIC, _TIMER_ABSTIME, reference, None)

        return sleep

    def plain(due: int) -> None:
        time.sleep(max(0, due - time.monotonic_ns()) / _NANO)

    return plain
