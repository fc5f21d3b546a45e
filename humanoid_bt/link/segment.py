"""A file that processes of one user map into memory."""

from __future__ import annotations

import fcntl
import mmap
import os
import secrets
import stat
from enum import IntEnum
from pathlib import Path
from typing import Self

from humanoid_bt.core.errors import HumanoidBtError

WORD = 8
"""Bytes of a word. An aligned word is stored and loaded whole by every processor this runs on."""

HEADER = 64
"""Bytes before a segment's own content: one cache line, so that what is written often lies in lines of its own."""

_MAGIC = int.from_bytes(b"HBTLINK1", "little")
_MAGIC_WORD, _KIND_WORD, _FIRST_INFO_WORD = 0, 1, 2
_MAX_INFO = HEADER // WORD - _FIRST_INFO_WORD
_PRIVATE = 0o600


class LinkError(HumanoidBtError):
    """What joins processes is missing, is not ours, or was used wrongly."""


class Kind(IntEnum):
    """What a segment holds."""

    RING = 1
    HEARTBEAT = 2
    ESTOP = 3
    TABLE = 4


class Segment:
    """A mapped file of one kind. Made by :meth:`create` and :meth:`open`.

    Attributes:
        path: the file.
        descriptor: the open file.
        words: the mapped part as native 64-bit words.
        bytes: the mapped part as bytes.
    """

    def __init__(self, path: Path, descriptor: int, length: int, access: int) -> None:
        self.path, self.descriptor = path, descriptor
        self.bytes = mmap.mmap(descriptor, length, access=access)
        self.words = memoryview(self.bytes).cast("Q")

    @classmethod
    def create(cls, path: Path, kind: Kind, size: int, info: tuple[int, ...] = (), append: bool = False) -> Self:
        """Make the file, whole at the moment it appears under its name, and map it for writing.

        Args:
            path: where; nothing may be there yet.
            kind: what it holds.
            size: of the header and the content [bytes], a whole number of words.
            info: numbers that readers need before anything else.
            append: writes to the descriptor go to the file's end, whatever other processes do.

        Raises:
            LinkError: something is there already, or there is no room.
        """
        if len(info) > _MAX_INFO or size < HEADER or size % WORD:
            raise ValueError(f"a segment of {size} bytes with {len(info)} numbers")
        draft = path.with_name(f".{path.name}.{secrets.token_hex(4)}")
        header = b"".join(word.to_bytes(WORD, "little") for word in (_MAGIC, kind, *info))
        try:
            descriptor = os.open(draft, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | _append(append), _PRIVATE)
        except OSError as error:
            raise LinkError(f"{path} cannot be made: {error.strerror}") from error
        try:
            # Zeros are written, not just promised by a length: a full /dev/shm is an error here and no SIGBUS later.
            _write_all(descriptor, header.ljust(size, b"\0"))
            os.link(draft, path)
            return cls(path, descriptor, size, mmap.ACCESS_WRITE)
        except OSError as error:
            os.close(descriptor)
            raise LinkError(f"{path} cannot be made: {error.strerror}") from error
        finally:
            draft.unlink()

    @classmethod
    def open(
        cls, path: Path, kind: Kind, write: bool, *, append: bool = False, length: int = 0, shared: bool = False
    ) -> Self:
        """Map an existing file.

        Args:
            path: the file.
            kind: what it must hold.
            write: also for writing.
            append: as in :meth:`create`.
            length: how much of it to map [bytes]; 0 for all.
            shared: also if others can reach it, as long as it is this user's.

        Raises:
            LinkError: there is none, it is not a private file of this user, or it holds something else.
        """
        flags = (os.O_RDWR if write else os.O_RDONLY) | os.O_NOFOLLOW | os.O_NONBLOCK | _append(append)
        try:
            descriptor = os.open(path, flags)
        except OSError as error:
            raise LinkError(f"{path} cannot be opened: {error.strerror}") from error
        try:
            status = os.fstat(descriptor)
            check_private(path, status, stat.S_ISREG(status.st_mode), shared)
            if status.st_size < max(length, HEADER):
                raise LinkError(f"{path} is too short: {status.st_size} bytes")
            whole = status.st_size // WORD * WORD
            segment = cls(path, descriptor, length or whole, mmap.ACCESS_WRITE if write else mmap.ACCESS_READ)
        except BaseException:
            os.close(descriptor)
            raise
        if segment.words[_MAGIC_WORD] != _MAGIC or segment.words[_KIND_WORD] != kind:
            segment.close()
            raise LinkError(f"{path} does not hold a {kind.name.lower()} of this version")
        return segment

    def claim(self) -> None:
        """Be the one writer, until this process ends or lets go of the file; close it if there is another one.

        Raises:
            LinkError: there is.
        """
        while not self._lock(fcntl.LOCK_EX):
            if self.has_writer:
                self.close()
                raise LinkError(f"{self.path} has a writer already")
            # else others ask for one at this moment, and that takes microseconds

    @property
    def has_writer(self) -> bool:
        """Whether a process that lives has claimed it."""
        if not self._lock(fcntl.LOCK_SH):
            return True
        self._lock(fcntl.LOCK_UN)
        return False

    def _lock(self, how: int) -> bool:
        """Return whether the file's lock could be had, or was let go, at once."""
        try:
            fcntl.flock(self.descriptor, how | fcntl.LOCK_NB)
        except OSError:
            return False
        return True

    def info(self, index: int) -> int:
        """Return one of the numbers given to :meth:`create`."""
        return self.words[_FIRST_INFO_WORD + index]

    def close(self) -> None:
        """Let go of the file; it stays where it is. Closing twice does nothing."""
        if self.descriptor >= 0:
            self.words.release()
            self.bytes.close()
            os.close(self.descriptor)
            self.descriptor = -1


def check_private(path: Path, status: os.stat_result, right_type: bool, shared: bool = False) -> None:
    """Refuse what another user made, or can reach if it is not shared.

    Raises:
        LinkError: it is of another type, owner or mode than this program gives.
    """
    mode = stat.S_IMODE(status.st_mode)
    if not right_type or status.st_uid != os.geteuid() or (mode & 0o077 and not shared):
        raise LinkError(
            f"{path} is not a private {'folder' if stat.S_ISDIR(status.st_mode) else 'file'} of this user "
            f"(owner {status.st_uid}, mode {mode:o}): somebody else may have made it; remove it"
        )


def _append(append: bool) -> int:
    return os.O_APPEND if append else 0


def _write_all(descriptor: int, content: bytes) -> None:
    left = memoryview(content)
    while left:
        left = left[os.write(descriptor, left) :]
