"""The e-stop: any process raises it, only an accepted reset clears it, and nobody ever waits for anybody.

The channel is a log that every process appends to and every process replays to the same state. An entry is appended
by one write to a file opened for appending, which the kernel does whole and in one order for all; there is no lock
that a killed or stopped process could keep. A word in memory, set to a new random number after each append, tells
readers that there is something to read.

A reset is an entry too, and so is control's answer to it. An accepted reset clears what was raised *before it was
asked for*: a later cause keeps the robot stopped.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import struct
from collections import Counter, deque
from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path
from typing import Self
from zlib import crc32

from humanoid_bt.link.segment import HEADER, WORD, Kind, LinkError, Segment

_HINT = HEADER // WORD  # word with the token of the last entry
_LOG_START = 4096  # bytes; entries never straddle a page, so none is ever half there
_ENTRY = 512  # bytes
_ENTRIES_PER_READ = 64  # bounds what one poll costs
_HEAD = struct.Struct("<IBBHH6xQQ")  # checksum, kind, accepted, bytes of source and of text, token, ticket
_CHECKSUM = struct.Struct("<I")
_SOURCE_ROOM, _TEXT_ROOM = 160, _ENTRY - _HEAD.size - 160  # bytes
_AUDIT_POLLS = 50  # polls between looks at the log itself: for a process killed between its entry and the hint
_NOTHING_READ = -1  # equals no hint
_UNKNOWN = "unknown"


class _Entry(IntEnum):
    RAISE = 1
    REQUEST = 2
    ANSWER = 3


@dataclass(frozen=True, slots=True)
class Raised:
    """The e-stop as it stands.

    Attributes:
        source: who raised it first.
        reason: why.
        count: causes that no reset has cleared.
    """

    source: str
    reason: str
    count: int


@dataclass(frozen=True, slots=True)
class ResetRequest:
    """A reset that control has not answered yet.

    Attributes:
        ticket: what its answer refers to.
        source: who asks.
    """

    ticket: int
    source: str


@dataclass(frozen=True, slots=True)
class ResetAnswer:
    """What control says to a reset.

    Attributes:
        accepted: whether what was raised before the request is cleared.
        reason: why not.
    """

    accepted: bool
    reason: str


class EStop:
    """One process's end of the e-stop. Made by :meth:`create` and :meth:`open`.

    What the properties say is as new as the last :meth:`poll`. For one thread; not for signal handlers.
    """

    def __init__(self, segment: Segment) -> None:
        self._segment, self._words = segment, segment.words
        self._seen_hint = _NOTHING_READ
        self._polls_to_audit = 1
        self._offset = _LOG_START
        self._changes = self._told_changes = 0
        self._tokens: set[int] = {0}  # 0 is the hint of an empty log
        self._causes: deque[tuple[str, str]] = deque()
        self._standing: Counter[tuple[str, str]] = Counter()
        self._total_causes = 0
        self._requests: dict[int, tuple[str, int]] = {}  # ticket -> who asks, causes raised before
        self._answers: dict[int, ResetAnswer] = {}

    @classmethod
    def create(cls, path: Path) -> Self:
        """Make an e-stop that nobody has raised.

        Raises:
            LinkError: the file cannot be made.
        """
        return cls(Segment.create(path, Kind.ESTOP, _LOG_START, append=True))

    @classmethod
    def open(cls, path: Path, shared: bool = False) -> Self:
        """Join an e-stop.

        Args:
            path: its file.
            shared: also if others can reach the file: who only raises it need not mind.

        Raises:
            LinkError: there is none.
        """
        return cls(Segment.open(path, Kind.ESTOP, write=True, append=True, length=_LOG_START, shared=shared))

    # ---- any process ----------------------------------------------------------------------------------------------

    def raise_(self, source: str, reason: str) -> None:
        """Raise the e-stop. It holds from the return of this call, whatever becomes of the caller.

        The same cause from the same source is not entered again while it stands and nobody asks for a reset.
        """
        source, reason = _cut(source, _SOURCE_ROOM), _cut(reason, _TEXT_ROOM)
        if self._read() and not self._requests and self._standing[source, reason]:
            self._seen_hint = _NOTHING_READ  # what was read here has still to be told by poll
            return
        token = _token()
        with contextlib.suppress(LinkError):  # no room for words: a hint without an entry is a cause too
            self._append(_Entry.RAISE, token, source, reason)
        self._words[_HINT] = token

    def request_reset(self, source: str) -> int:
        """Ask control to clear the e-stop, and return the ticket that :meth:`answer_to` takes.

        Raises:
            LinkError: the request cannot be written.
        """
        ticket = _token()
        self._append(_Entry.REQUEST, ticket, source, "")
        self._words[_HINT] = ticket
        return ticket

    def answer_to(self, ticket: int) -> ResetAnswer | None:
        """Return control's answer, None while there is none."""
        return self._answers.get(ticket)

    def poll(self) -> bool:
        """Take note of what is new; return whether anything is."""
        self._polls_to_audit -= 1
        if self._polls_to_audit and self._words[_HINT] == self._seen_hint:
            return False
        self._polls_to_audit = _AUDIT_POLLS
        self._read()
        told, self._told_changes = self._told_changes, self._changes
        return told != self._changes

    @property
    def raised(self) -> Raised | None:
        """The first cause that stands, None if the e-stop is clear."""
        if not self._causes:
            return None
        source, reason = self._causes[0]
        return Raised(source, reason, len(self._causes))

    # ---- control --------------------------------------------------------------------------------------------------

    @property
    def reset_request(self) -> ResetRequest | None:
        """The oldest request without an answer."""
        for ticket, (source, _) in self._requests.items():
            return ResetRequest(ticket, source)
        return None

    def answer(self, ticket: int, accepted: bool, reason: str = "") -> None:
        """Accept or refuse a reset. Look at :attr:`raised` afterwards: what was raised since the request stands.

        Raises:
            LinkError: the answer cannot be written; nothing is cleared then.
        """
        token = _token()
        self._append(_Entry.ANSWER, token, "", reason, accepted=accepted, ticket=ticket)
        self._words[_HINT] = token
        while not self._read():
            pass
        self._seen_hint = _NOTHING_READ

    def close(self) -> None:
        """Let go of the e-stop; what was raised stands."""
        self._segment.close()

    # ---- the log --------------------------------------------------------------------------------------------------

    def _append(
        self, kind: _Entry, token: int, source: str, text: str, *, accepted: bool = False, ticket: int = 0
    ) -> None:
        who, words = _cut(source, _SOURCE_ROOM).encode(), _cut(text, _TEXT_ROOM).encode()
        entry = bytearray(_ENTRY)
        _HEAD.pack_into(entry, 0, 0, kind, accepted, len(who), len(words), token, ticket)
        entry[_HEAD.size : _HEAD.size + len(who) + len(words)] = who + words
        _CHECKSUM.pack_into(entry, 0, crc32(memoryview(entry)[_CHECKSUM.size :]))
        try:
            written = os.write(self._segment.descriptor, entry)
        except OSError as error:
            raise LinkError(f"{self._segment.path} cannot be written: {error.strerror}") from error
        if written != _ENTRY:
            raise LinkError(f"{self._segment.path} cannot be written: no room")

    def _read(self) -> bool:
        """Replay a bounded number of new entries; return whether the end of the log was reached."""
        hint = self._words[_HINT]  # before the log: whose hint is seen, their entry is in it
        content = os.pread(self._segment.descriptor, _ENTRIES_PER_READ * _ENTRY, self._offset)
        count = len(content) // _ENTRY
        for index in range(count):
            self._apply(content[index * _ENTRY : (index + 1) * _ENTRY])
        self._offset += count * _ENTRY
        if count == _ENTRIES_PER_READ:
            self._seen_hint = _NOTHING_READ
            return False
        if hint not in self._tokens:
            self._tokens.add(hint)
            self._cause(_UNKNOWN, "raised without room for its reason")
        self._seen_hint = hint
        return True

    def _apply(self, entry: bytes) -> None:
        checksum, kind, accepted, who_size, text_size, token, ticket = _HEAD.unpack_from(entry)
        if checksum != crc32(memoryview(entry)[_CHECKSUM.size :]):
            kind = 0  # none of ours
        else:
            self._tokens.add(token)
        who_end = _HEAD.size + who_size
        source = entry[_HEAD.size : who_end].decode(errors="replace")
        text = entry[who_end : who_end + text_size].decode(errors="replace")
        match kind:
            case _Entry.RAISE:
                self._cause(source, text)
            case _Entry.REQUEST:
                self._requests[token] = source, self._total_causes
                self._changes += 1
            case _Entry.ANSWER:
                self._answered(ticket, ResetAnswer(bool(accepted), text))
            case _:
                self._cause(_UNKNOWN, "an entry of the e-stop is unreadable")

    def _cause(self, source: str, reason: str) -> None:
        self._causes.append((source, reason))
        self._standing[source, reason] += 1
        self._total_causes += 1
        self._changes += 1

    def _answered(self, ticket: int, answer: ResetAnswer) -> None:
        request = self._requests.pop(ticket, None)
        if request is None:
            return
        self._answers[ticket] = answer
        self._changes += 1
        if answer.accepted:
            later = self._total_causes - request[1]
            while len(self._causes) > later:
                self._standing[self._causes.popleft()] -= 1


def _token() -> int:
    return secrets.randbits(63) + 1


def _cut(text: str, room: int) -> str:
    """Return text that fits into a number of bytes of UTF-8, cut between characters."""
    return text.encode(errors="backslashreplace")[:room].decode(errors="ignore")
