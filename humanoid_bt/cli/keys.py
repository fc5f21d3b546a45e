"""Single keys, heard in a terminal while a program runs."""

from __future__ import annotations

import os
import re
import select
import sys
import termios
import threading
import tty
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

_POLL = 0.1  # s between looks whether the run is over
_LONGEST = 64  # bytes taken at once
_SEQUENCE = re.compile(r"\x1b(\[[0-?]*[ -/]*[@-~]|O.)?")  # what arrows and function keys send; see ECMA-48


def available() -> bool:
    """Return whether somebody sits at a terminal that belongs to this program now."""
    try:
        descriptor = sys.stdin.fileno()
        return sys.stdin.isatty() and sys.stdout.isatty() and os.tcgetpgrp(descriptor) == os.getpgrp()
    except (AttributeError, OSError, ValueError):  # no standard input at all
        return False


@contextmanager
def listening(actions: Mapping[str, Callable[[], None]]) -> Iterator[None]:
    """Call an action per key pressed, in a thread of its own: a key works while a skill hangs.

    The terminal is as it was afterwards, whatever happens in between.

    Args:
        actions: key -> what it does; from another thread.
    """
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    over = threading.Event()
    thread = threading.Thread(target=_listen, args=(descriptor, actions, over), name="keys", daemon=True)
    try:
        tty.setcbreak(descriptor, termios.TCSADRAIN)
        thread.start()
        yield
    finally:
        over.set()
        if thread.is_alive():
            thread.join(5 * _POLL)
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _listen(descriptor: int, actions: Mapping[str, Callable[[], None]], over: threading.Event) -> None:
    while not over.is_set():
        try:
            ready, _, _ = select.select([descriptor], [], [], _POLL)
            if not ready or os.tcgetpgrp(descriptor) != os.getpgrp():  # reading in the background would stop us
                over.wait(0 if not ready else _POLL)
                continue
            pressed = os.read(descriptor, _LONGEST)
        except OSError:
            return  # the terminal is gone
        if not pressed:
            return
        for key in _SEQUENCE.sub("", pressed.decode(errors="ignore")).lower():
            if key in actions:
                actions[key]()
