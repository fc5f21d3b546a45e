"""Ctrl-C: what it does while nothing has begun, and whose a KeyboardInterrupt is."""

from __future__ import annotations

import os
import signal
import threading
import traceback
from types import FrameType


def is_ctrl_c(error: BaseException) -> bool:
    """Return whether an exception comes from a signal's handler, and not from the code that it interrupted.

    Python's own handler leaves no trace: what comes while it is in force counts as somebody's.
    """
    if not isinstance(error, KeyboardInterrupt):
        return False
    handler = signal.getsignal(signal.SIGINT)
    if handler is signal.default_int_handler:
        return threading.current_thread() is threading.main_thread()  # no other thread gets the signal
    code = getattr(handler, "__code__", None)
    return any(frame.f_code is code for frame, _ in traceback.walk_tb(error.__traceback__))


def end_at_once() -> None:
    """Let Ctrl-C end the program at once while nothing has begun: an import that is torn prints a traceback."""
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, _end)


def raise_it() -> None:
    """Let Ctrl-C be raised as Python does, after :func:`end_at_once`."""
    if signal.getsignal(signal.SIGINT) is _end:
        signal.signal(signal.SIGINT, signal.default_int_handler)


def _end(number: int, _frame: FrameType | None) -> None:
    os.write(2, b"interrupted\n")
    os._exit(128 + number)
