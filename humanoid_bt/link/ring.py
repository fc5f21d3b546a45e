"""A ring of slots from one writer to any number of readers that never wait for each other.

A slot is ``sequence | length and checksum | payload``. The writer invalidates the slot, fills it, validates it and
publishes its sequence in the head last. A reader copies the payload and believes it only if the slot still has the
sequence it came for and the checksum, which starts from that sequence, is right. So neither a writer killed in the
middle of a write nor one that laps the reader makes it return torn data, whatever order the processor stores in.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Self
from zlib import crc32

from humanoid_bt.link.segment import HEADER, WORD, Kind, LinkError, Segment

_HEAD = HEADER // WORD  # word that holds the newest sequence; 0 before the first write
_FIRST_SLOT = 2 * HEADER  # the head has a cache line of its own
_SLOT_HEADER = 2 * WORD
_CACHE_LINE = 64  # bytes; slots start on one
_MIN_SLOTS = 4  # with fewer a busy writer starves its readers
_CRC_MASK = 0xFFFFFFFF
_LENGTH_SHIFT = 32
_ATTEMPTS = 16  # one fails if the writer laps the whole ring during a copy: 16 in a row mean a broken ring


def _stride(slot_size: int) -> int:
    return -(-(_SLOT_HEADER + slot_size) // _CACHE_LINE) * _CACHE_LINE


class RingWriter:
    """The one writer. Made by :meth:`create`, or by :meth:`open` after an earlier writer has ended.

    Attributes:
        sequence: of the last write, counted from 1; 0 before the first.
    """

    def __init__(self, segment: Segment) -> None:
        segment.claim()
        self._segment = segment
        self._words, self._bytes = segment.words, segment.bytes
        self.slot_size, self._slots = segment.info(0), segment.info(1)
        self._stride = _stride(self.slot_size)
        self.sequence = self._words[_HEAD]

    @classmethod
    def create(cls, path: Path, slot_size: int, slots: int = 8) -> Self:
        """Make an empty ring.

        Args:
            path: where; nothing may be there yet.
            slot_size: the longest payload [bytes].
            slots: how many; one less is what :meth:`RingReader.since` can still return of the past.

        Raises:
            LinkError: the file cannot be made.
        """
        if slots < _MIN_SLOTS or not 0 < slot_size <= _CRC_MASK:
            raise ValueError(f"a ring of {slots} slots of {slot_size} bytes: at least {_MIN_SLOTS} slots, 1 byte")
        size = _FIRST_SLOT + slots * _stride(slot_size)
        return cls(Segment.create(path, Kind.RING, size, (slot_size, slots)))

    @classmethod
    def open(cls, path: Path) -> Self:
        """Go on writing where an earlier writer stopped, also one that was killed.

        Raises:
            LinkError: there is no ring, or its writer is still there.
        """
        return cls(_open(path, write=True))

    def write(self, payload: bytes | bytearray | memoryview[Any]) -> int:
        """Publish a payload and return its sequence.

        Raises:
            LinkError: it is longer than a slot.
        """
        length = payload.nbytes if isinstance(payload, memoryview) else len(payload)
        if length > self.slot_size:
            raise LinkError(f"{length} bytes do not fit into a slot of {self.slot_size} bytes")
        words = self._words
        sequence = self.sequence + 1
        start = _FIRST_SLOT + sequence % self._slots * self._stride
        word = start >> 3
        words[word] = 0
        self._bytes[start + _SLOT_HEADER : start + _SLOT_HEADER + length] = payload
        words[word + 1] = length << _LENGTH_SHIFT | crc32(payload, sequence & _CRC_MASK)
        words[word] = sequence
        words[_HEAD] = sequence
        self.sequence = sequence
        return sequence

    def close(self) -> None:
        """Let go of the ring; readers go on reading what is in it."""
        self._segment.close()


class RingReader:
    """A reader; one per process or thread.

    Attributes:
        failures: how often :meth:`latest` found nothing intact although something was published.
    """

    def __init__(self, segment: Segment) -> None:
        self._segment = segment
        self._words, self._bytes = segment.words, segment.bytes
        self._slot_size, self._slots = segment.info(0), segment.info(1)
        self._stride = _stride(self._slot_size)
        self.failures = 0

    @classmethod
    def open(cls, path: Path) -> Self:
        """Map a ring for reading only.

        Raises:
            LinkError: there is none.
        """
        return cls(_open(path, write=False))

    @property
    def sequence(self) -> int:
        """The newest sequence, 0 before the first write: a cheap way to see that there is something new."""
        return self._words[_HEAD]

    @property
    def has_writer(self) -> bool:
        """Whether a process that lives has it open for writing."""
        return self._segment.has_writer

    def latest(self) -> tuple[int, bytes] | None:
        """Return the newest (sequence, payload).

        None before the first write. None too if nothing intact could be read in a bounded number of attempts, which
        only a damaged ring or a writer lapping all slots within every single attempt can cause; that is counted.
        """
        words = self._words
        for _ in range(_ATTEMPTS):
            sequence = words[_HEAD]
            if not sequence:
                return None
            payload = self._read(sequence)
            if payload is not None:
                return sequence, payload
        self.failures += 1
        return None

    def since(self, sequence: int) -> tuple[list[tuple[int, bytes]], int]:
        """Return what was published after a sequence, oldest first, and how much of it is lost.

        Args:
            sequence: of the last entry already read; 0 for none.

        Returns:
            (sequence, payload) of each entry still there, and the number of entries that the writer overwrote before
            they were read. Without entries nothing is counted yet, so that the next call counts it once.
        """
        head = self._words[_HEAD]
        entries: list[tuple[int, bytes]] = []
        for wanted in range(max(sequence + 1, head - self._slots + 1), head + 1):
            payload = self._read(wanted)
            if payload is not None:
                entries.append((wanted, payload))
        lost = entries[-1][0] - sequence - len(entries) if entries else 0
        return entries, lost

    def _read(self, sequence: int) -> bytes | None:
        """Return the payload of a sequence, or None if its slot does not hold it intact."""
        words = self._words
        start = _FIRST_SLOT + sequence % self._slots * self._stride
        word = start >> 3
        if words[word] != sequence:
            return None
        sum_and_length = words[word + 1]
        length = sum_and_length >> _LENGTH_SHIFT
        if length > self._slot_size:
            return None
        payload = self._bytes[start + _SLOT_HEADER : start + _SLOT_HEADER + length]
        if words[word] != sequence or crc32(payload, sequence & _CRC_MASK) != sum_and_length & _CRC_MASK:
            return None
        return payload

    def close(self) -> None:
        """Let go of the ring."""
        self._segment.close()


def _open(path: Path, write: bool) -> Segment:
    segment = Segment.open(path, Kind.RING, write)
    slot_size, slots = segment.info(0), segment.info(1)
    if slots < _MIN_SLOTS or _FIRST_SLOT + slots * _stride(slot_size) != len(segment.bytes):
        segment.close()
        raise LinkError(f"{path} is a damaged ring")
    return segment
