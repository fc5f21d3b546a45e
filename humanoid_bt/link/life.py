"""Whether a process lives: it has a file open that is locked, and the kernel lets go of it for one that dies.

That says the same in every container that shares the folder. Process ids do not: each counts its own.
"""

from __future__ import annotations

import fcntl
import os
from contextlib import suppress
from pathlib import Path

_ours: set[int] = set()


def begin(path: Path) -> int:
    """Return the descriptor of a new locked file: whoever has it open lives, this process or one it is passed to.

    Raises:
        OSError: the file cannot be made.
    """
    path.unlink(missing_ok=True)  # that of a process which had the same part before, and died
    descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW, 0o600)
    fcntl.flock(descriptor, fcntl.LOCK_EX)
    _ours.add(descriptor)
    return descriptor


def end(descriptor: int) -> None:
    """Let go of what :func:`begin` returned."""
    _ours.discard(descriptor)
    os.close(descriptor)


def lives(path: Path) -> bool:
    """Return whether anybody has a file locked, as whoever has that of :func:`begin` open."""
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:  # most likely: another has the lock
        return True
    finally:
        os.close(descriptor)
    return False


def _die() -> None:
    """Let go of everything: this process was forked by a skill, and is none of its parent's run."""
    for descriptor in _ours:
        with suppress(OSError):
            os.close(descriptor)
    _ours.clear()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_die)
