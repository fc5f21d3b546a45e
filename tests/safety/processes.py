"""Processes known by a mark in their environment, whoever started them and whoever their parent is now."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

MARK = "HUMANOID_BT_CHAOS"
"""Variable of the environment that carries the mark."""

_PERIOD = 0.5  # s between two looks
_STARTED = 6.0  # s after which a process has everything that it needs
_PAGE = os.sysconf("SC_PAGE_SIZE")
_ROLES = ("control", "perception", "recorder", "camera")


class Process(NamedTuple):
    """A process: its id, its part in the run, and its memory that no other process shares [bytes]."""

    pid: int
    role: str
    memory: int


def marked(mark: str) -> Iterator[Process]:
    """Yield the processes that live and carry a mark; a zombie has no environment any more."""
    entry = f"{MARK}={mark}".encode()
    for folder in Path("/proc").glob("[0-9]*"):
        with suppress(OSError):  # it has just ended, or is another user's
            if entry in (folder / "environ").read_bytes().split(b"\0"):
                command = (folder / "cmdline").read_text()
                resident, shared = map(int, (folder / "statm").read_text().split()[1:3])
                yield Process(int(folder.name), _role(command), (resident - shared) * _PAGE)


def _role(command: str) -> str:
    return next((role for role in _ROLES if f".{role}_process" in command), "decision" if "\0run\0" in command else "")


@dataclass
class Life:
    """What a process took: its part, how long it was seen [s], its memory when it had started, at most and at last."""

    role: str
    seen: float = 0.0
    started: int = 0
    most: int = 0
    last: int = 0


class Watch:
    """Looks at the memory of all processes with a mark, twice a second, until it is left.

    Attributes:
        lives: process id -> what it took.
    """

    def __init__(self, mark: str) -> None:
        self._mark, self._over = mark, threading.Event()
        self.lives: dict[int, Life] = {}
        self._thread = threading.Thread(target=self._look, daemon=True)

    def __enter__(self) -> Watch:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()

    def _look(self) -> None:
        while not self._over.wait(_PERIOD):
            for process in marked(self._mark):
                if process.role:
                    self._note(process)

    def _note(self, process: Process) -> None:
        life = self.lives.setdefault(process.pid, Life(process.role))
        life.role = process.role  # before it had begun its own program it seemed to be its parent
        life.seen += _PERIOD
        life.last, life.most = process.memory, max(life.most, process.memory)
        if life.seen <= _STARTED:
            life.started = process.memory
