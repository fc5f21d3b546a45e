"""Ctrl-C between ticks: one is never torn by it."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from types import FrameType
from typing import Self

from humanoid_bt.core import forks

_MOST = 2  # of them that are handled


class WholeTick:
    """Holds Ctrl-C back until what it is entered for is done, and then raises KeyboardInterrupt.

    A second one is not held back. A skill may catch that; the third kills the program.

    Programs that handle the signal themselves, and threads that do not get it, are left alone. Use it as a context
    manager, around one tick, or around many with :meth:`over` after each: to hold it back anew for each takes 20 us.

    Args:
        on_hold: told that one is held back, in the signal's handler.
    """

    def __init__(self, on_hold: Callable[[str], None] | None = None) -> None:
        self._on_hold = on_hold

    def __enter__(self) -> Self:
        self._count, self._process = 0, os.getpid()
        self._ours = (
            threading.current_thread() is threading.main_thread()
            and signal.getsignal(signal.SIGINT) is signal.default_int_handler
        )
        if self._ours:
            signal.signal(signal.SIGINT, self._note)
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if self._ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        if self._count and kind is None:
            raise KeyboardInterrupt

    def over(self) -> None:
        """Raise KeyboardInterrupt if one was held back: a tick is over, and others are to come."""
        if self._count:
            raise KeyboardInterrupt

    def _note(self, number: int, _frame: FrameType | None) -> None:
        if os.getpid() != self._process or self._count >= _MOST:
            forks.die_of(number)
        self._count += 1
        if self._count > 1:
            raise KeyboardInterrupt
        if self._on_hold is not None:
            self._on_hold("Ctrl-C")
