"""Whose a KeyboardInterrupt is: somebody's at the keyboard, or the code's that raised it."""

from __future__ import annotations

import signal
import threading
import traceback


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
