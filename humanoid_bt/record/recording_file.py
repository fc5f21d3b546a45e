"""The file of a recording while it is written: one writer, and whether it has everything."""

from __future__ import annotations

import fcntl
import os
import resource
import tempfile
from pathlib import Path

from humanoid_bt.core.errors import UserError, relative

_FOOTER, _TAIL = b"RRF2FOOT", 12  # what a whole recording ends with, and the bytes in which that stands
_BLOCK = 1 << 16  # bytes: what cannot be written of a recording is smaller than this


class RecordingFile:
    """Watches a file that another part of this process writes, and keeps other runs away from it.

    Args:
        path: the file.

    Attributes:
        path: the file.
        size: bytes that it had at the last check.
        trouble: what is wrong with it, "" while nothing is.
        deleted: whether nobody can open it any more.

    Raises:
        UserError: another run writes it, or it cannot be opened.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._shown = relative(path)
        self.trouble, self.deleted = "", False
        self.size = -1
        try:
            self._descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise UserError(f"the recording {self._shown!r} cannot be written: {error.strerror}") from error
        try:
            fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(self._descriptor)
            hint = "give another file with --record FILE (record=FILE in Python)"
            raise UserError(f"the recording {self._shown!r} is being written by another run", hint=hint) from None

    def check(self) -> bool:
        """Return whether something came to it since the last check and it can still be opened."""
        status = os.fstat(self._descriptor)
        grown, self.size = status.st_size > self.size, status.st_size
        if not status.st_nlink:
            self.deleted = True
            self.trouble = self.trouble or f"the recording {self._shown!r} was deleted while it was written"
        elif not grown and not self.trouble and (reason := self.refusal()):
            self.trouble = f"the recording {self._shown!r} is cut short: {reason}"
        return grown and not self.deleted

    def check_end(self) -> bool:
        """Return what :meth:`check` does, of a file to which nothing more will come."""
        grown = self.check()
        if not self.trouble and _FOOTER not in os.pread(self._descriptor, _TAIL, max(0, self.size - _TAIL)):
            self.trouble = f"the recording {self._shown!r} has no proper end: {self.refusal() or 'nobody knows why'}"
        return grown

    def close(self) -> None:
        """Let go of it."""
        os.close(self._descriptor)

    def give_up(self) -> str:
        """Let go of it and remove it; return why the system lets nobody write, "" if it does."""
        why = self.refusal()
        self.path.unlink(missing_ok=True)
        self.close()
        return why

    def refusal(self) -> str:
        """Return why the system lets nobody write, "" if it does."""
        limit, _ = resource.getrlimit(resource.RLIMIT_FSIZE)
        if limit != resource.RLIM_INFINITY and os.fstat(self._descriptor).st_size + _BLOCK > limit:
            return f"files may have {limit} bytes at most here (ulimit -f)"
        try:
            with tempfile.TemporaryFile(dir=self.path.parent) as probe:
                probe.write(bytes(_BLOCK))
        except OSError as error:
            return f"{error.strerror}"
        return ""
