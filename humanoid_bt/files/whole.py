"""Files that are written whole or not at all."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from pathlib import Path


def write_whole(path: Path, content: bytes) -> None:
    """Put content into a file at once, or leave the file as it is.

    A link stays, and so do the permissions of a file that is replaced. A pipe, a device and what a process has open,
    such as ``/dev/stdout``, are written as they are.

    Raises:
        OSError: it cannot be written.
    """
    if _is_open(path):
        path.write_bytes(content)
        return
    target = _target(path)
    draft = target.with_name(f".{target.name[:60]}.{secrets.token_hex(4)}")  # 250 bytes at most, and 255 are allowed
    try:
        with os.fdopen(os.open(draft, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666), "wb") as file:
            if target.exists():
                os.fchmod(file.fileno(), target.stat().st_mode & 0o7777)
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        draft.replace(target)
    except BaseException:
        with contextlib.suppress(OSError):
            draft.unlink()
        raise


def make_way(path: Path) -> None:
    """Remove what stands where :func:`write_whole` will write, having found out that it can.

    Raises:
        OSError: it will not be able to.
    """
    if _is_open(path):
        return
    target = _target(path)
    if target.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if target.exists() and not os.access(target, os.W_OK):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
    write_whole(target, b"")
    target.unlink()


def _is_open(path: Path) -> bool:
    """Return whether nothing can take the place of a file."""
    if not path.exists() or path.is_dir():
        return False
    steps = [path.parent.resolve(), path.readlink()] if path.is_symlink() else []
    return not path.is_file() or any(step.is_relative_to("/proc") for step in steps)


def _target(path: Path) -> Path:
    """Return what a path points to in the end, as far as it exists.

    Raises:
        OSError: its links lead in a circle.
    """
    try:
        return path.resolve()
    except RuntimeError as error:
        raise OSError(errno.ELOOP, os.strerror(errno.ELOOP), str(path)) from error
