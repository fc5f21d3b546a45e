"""Reading files that people give: regular ones of a sane size, whatever stands at their path."""

from __future__ import annotations

import errno
import os
import stat
from pathlib import Path

from humanoid_bt.core.errors import Place, UserError, relative, resolved

MAX_BYTES = 4_000_000
"""Largest file that is read: tree, scene, robot or skill."""

_KINDS = {
    stat.S_IFIFO: "a pipe",
    stat.S_IFSOCK: "a socket",
    stat.S_IFCHR: "a device",
    stat.S_IFBLK: "a device",
}


def read_bytes(path: Path, most: int = MAX_BYTES) -> bytes:
    """Return what a file holds.

    Raises:
        UserError: it cannot be read, is no regular file, or is too large.
    """
    place = Place(relative(path))
    try:
        # not blocking: opening a pipe would wait for somebody who writes
        with os.fdopen(os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_CLOEXEC), "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode):
                kind = _KINDS.get(stat.S_IFMT(status.st_mode), "something else")
                raise UserError(f"cannot be read: it is {kind}, not a file", place, code="unreadable")
            content = file.read(most + 1)
    except (OSError, ValueError) as error:
        if isinstance(error, UserError):
            raise
        raise UserError(f"cannot be read: {_reason(error)}", place, code="unreadable") from error
    if len(content) > most:
        size = max(status.st_size, len(content))
        message = f"the file is too large: {size / 1e6:,.1f} MB"
        raise UserError(message, place, f"at most {most / 1e6:g} MB are read", "too-large")
    return content


def read_text(path: Path) -> str:
    """Return a file's text, every line break as one character.

    Raises:
        UserError: as :func:`read_bytes`, or it is not UTF-8.
    """
    content = read_bytes(path)
    try:
        text = content.decode("utf-8")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode("utf-8")
        place = Place(relative(path), before.count("\n") + 1, len(before) - before.rfind("\n"))
        raise UserError("the file is not UTF-8 text", place, code="unreadable") from error
    return text.replace("\r\n", "\n").replace("\r", "\n")


def is_file(path: Path) -> bool:
    """Return whether there is something to read at a path; what no path can be is none."""
    try:
        return path.exists() and not path.is_dir()
    except (OSError, ValueError):
        return False


def followed(path: Path) -> Path:
    """Return a file without links; a link that leads nowhere as it is, since that is what there is."""
    return resolved(path) if is_file(path) else path.absolute()


def is_folder(path: Path) -> bool:
    """Return whether there is a folder at a path; what no path can be is none."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def _reason(error: OSError | ValueError) -> str:
    if isinstance(error, OSError):
        return os.strerror(error.errno) if error.errno else str(error)
    return os.strerror(errno.EINVAL)
