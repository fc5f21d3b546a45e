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
from typing import NamedTuple

_POLL = 0.1  # s between looks whether the run is over
_LONGEST = 64  # bytes taken at once
_LONGEST_LINE = 4096
_CTRL_D = "\x04"  # typed before the terminal takes lines
_SEQUENCE = re.compile(r"\x1b(\[[0-?]*[ -/]*[@-~]|O.)?")  # what arrows and function keys send; see ECMA-48


class Prompt(NamedTuple):
    """What takes lines that are typed, from another thread.

    Attributes:
        begin: is told that the first line begins.
        take: is given a line, and returns whether another one follows; what is typed then is a key no sooner.
    """

    begin: Callable[[], None]
    take: Callable[[str], bool]


def available() -> bool:
    """Return whether somebody sits at a terminal that belongs to this program now."""
    try:
        descriptor = sys.stdin.fileno()
        return sys.stdin.isatty() and sys.stdout.isatty() and os.tcgetpgrp(descriptor) == os.getpgrp()
    except (AttributeError, OSError, ValueError):  # no standard input at all
        return False


@contextmanager
def listening(actions: Mapping[str, Callable[[], None]], prompts: Mapping[str, Prompt] | None = None) -> Iterator[None]:
    """Call an action per key pressed, in a thread of its own: a key works while a skill hangs.

    The terminal is as it was afterwards, whatever happens in between.

    Args:
        actions: key -> what it does; from another thread.
        prompts: key -> what takes the lines that are typed behind it.
    """
    descriptor = sys.stdin.fileno()
    before = termios.tcgetattr(descriptor)
    over = threading.Event()
    thread = threading.Thread(target=_listen, args=(descriptor, actions, prompts or {}, over), name="keys", daemon=True)
    try:
        tty.setcbreak(descriptor, termios.TCSADRAIN)
        thread.start()
        yield
    finally:
        over.set()
        if thread.is_alive():
            thread.join(5 * _POLL)
        termios.tcsetattr(descriptor, termios.TCSADRAIN, before)


def _listen(
    descriptor: int,
    actions: Mapping[str, Callable[[], None]],
    prompts: Mapping[str, Prompt],
    over: threading.Event,
) -> None:
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
        keys = _SEQUENCE.sub("", pressed.decode(errors="ignore"))
        while keys:
            key, keys = keys[0].lower(), keys[1:]
            if key in actions:
                actions[key]()
            elif key in prompts:
                prompts[key].begin()
                more = True
                while more:
                    line, keys = _line(descriptor, keys, over)
                    more = prompts[key].take(_SEQUENCE.sub("", line))


def _line(descriptor: int, begun: str, over: threading.Event) -> tuple[str, str]:
    """Return a line as the terminal lets one be typed and mended, and what came behind it; "" if the run is over.

    Args:
        descriptor: of the terminal.
        begun: what has been typed already.
        over: when to give up.
    """
    raw = termios.tcgetattr(descriptor)
    edited = termios.tcgetattr(descriptor)
    edited[tty.LFLAG] |= termios.ICANON | termios.ECHO
    try:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, edited)
        while "\n" not in begun and not over.is_set():
            if select.select([descriptor], [], [], _POLL)[0]:
                typed = os.read(descriptor, _LONGEST_LINE).decode(errors="ignore")
                begun += typed.replace(_CTRL_D, "\n") or "\n"  # the end of input is that of the line
    finally:
        termios.tcsetattr(descriptor, termios.TCSADRAIN, raw)
    line, _, behind = begun.partition("\n")
    return ("" if over.is_set() else line), behind
