"""Journals: files that are only appended to, so that a kill or a full disk costs at most what was being written."""

from __future__ import annotations

import fcntl
import json
import os
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from humanoid_bt.core.errors import HumanoidBtError, UserError, relative

Entry = dict[str, Any]


class Unwritable(HumanoidBtError):  # noqa: N818 (the name says it)
    """What was found out cannot be written any more, such as on a full disk."""


class Journal:
    """Entries of a file, one a line, each of a number that no other has.

    A line counts when it ends: what a kill tore is cut off when the file is opened again.

    Args:
        path: the file; made if it is not there.

    Attributes:
        entries: all of them, by number.

    Raises:
        UserError: another process writes it, or it is no journal.
        Unwritable: it cannot be made.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise _unwritable(path, error) from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            os.close(self._file)
            raise UserError(f"a campaign writes to {relative(path.parent)!r} just now", hint="one at a time") from error
        self.entries = self._read()

    def add(self, number: int, entry: Entry) -> None:
        """Write an entry down.

        Raises:
            ValueError: there is one of this number.
            Unwritable: it cannot be written; the file is as it was before.
        """
        if number in self.entries:
            raise ValueError(f"{number} is in the journal already")
        line = json.dumps({"trial": number, **entry}, allow_nan=False, separators=(",", ":")).encode() + b"\n"
        end = os.fstat(self._file).st_size
        try:
            written = os.write(self._file, line)
            while written < len(line):  # a disk that is nearly full takes a part, and says why the next time
                written += os.write(self._file, line[written:])
        except OSError as error:
            os.ftruncate(self._file, end)
            raise _unwritable(self._path, error) from error
        self.entries[number] = entry

    def close(self) -> None:
        """Let what was written reach the disk; others may write from now on."""
        try:
            os.fsync(self._file)
        except OSError as error:
            raise _unwritable(self._path, error) from error
        finally:
            os.close(self._file)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _trace: TracebackType | None
    ) -> None:
        self.close()

    def _read(self) -> dict[int, Entry]:
        content = self._path.read_bytes()
        whole = content.rfind(b"\n") + 1
        found: dict[int, Entry] = {}
        try:
            for line in content[:whole].splitlines():
                entry = json.loads(line)
                found.setdefault(entry.pop("trial"), entry)
        except (ValueError, LookupError, TypeError, AttributeError) as error:
            raise UserError(f"{relative(self._path)!r} is no journal of a campaign, or is damaged") from error
        os.ftruncate(self._file, whole)
        return found


def read_journal(path: Path) -> dict[int, Entry]:
    """Return the entries of a journal, also while somebody writes it.

    Raises:
        UserError: it cannot be read.
    """
    try:
        lines = path.read_bytes().splitlines(keepends=True)
        entries = [json.loads(line) for line in lines if line.endswith(b"\n")]
        return {entry.pop("trial"): entry for entry in reversed(entries)}
    except (OSError, ValueError, LookupError, TypeError, AttributeError) as error:
        raise UserError(f"{relative(path)!r} is no journal of a campaign, or is damaged") from error


def _unwritable(path: Path, error: OSError) -> Unwritable:
    return Unwritable(f"{relative(path)!r} cannot be written: {error.strerror}")
