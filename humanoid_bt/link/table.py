"""Rows of numbers from one writer, written in place: for what is written too often for a ring.

A ring's entry is made first, and then checked and copied. Here the writer fills the next row where it lies, and
publishes it with one store. A reader leaves out the rows that the writer may have come round to while it copied them;
what it missed is counted.
"""

from __future__ import annotations

from pathlib import Path
from typing import Self

import numpy as np

from humanoid_bt.core.messages import Array
from humanoid_bt.link.segment import HEADER, WORD, Kind, LinkError, Segment

_COUNT = HEADER // WORD  # word that holds how many rows were published
_FIRST_ROW = 2 * HEADER  # the count has a cache line of its own
_MIN_ROWS = 8
_SPARE = 2  # rows that a reader leaves out: the one that is being written, and its neighbour


class TableWriter:
    """The one writer.

    Attributes:
        rows: the rows, shape (rows, width); the next one is ``rows[count % len(rows)]``.
        count: how many were published.
    """

    def __init__(self, segment: Segment) -> None:
        segment.claim()
        self._segment, self._words = segment, segment.words
        self.rows = _rows(segment)
        self.count = self._words[_COUNT]

    @classmethod
    def create(cls, path: Path, width: int, rows: int) -> Self:
        """Make an empty table.

        Args:
            path: where; nothing may be there yet.
            width: numbers in a row.
            rows: how many are kept.

        Raises:
            LinkError: the file cannot be made.
        """
        if rows < _MIN_ROWS or width < 1:
            raise ValueError(f"a table of {rows} rows of {width} numbers: at least {_MIN_ROWS} rows, 1 number")
        return cls(Segment.create(path, Kind.TABLE, _FIRST_ROW + rows * width * WORD, (width, rows)))

    @classmethod
    def open(cls, path: Path) -> Self:
        """Go on writing where an earlier writer stopped.

        Raises:
            LinkError: there is no table, or its writer is still there.
        """
        return cls(_open(path, write=True))

    def publish(self) -> None:
        """Let readers see the row that was filled last."""
        self.count += 1
        self._words[_COUNT] = self.count

    def close(self) -> None:
        """Let go of the table; its rows cannot be used any more."""
        del self.rows
        self._segment.close()


class LocalTable:
    """A table within one process, whose writer and reader take turns.

    Attributes:
        rows, count: as of a :class:`TableWriter`.
    """

    def __init__(self, width: int, rows: int) -> None:
        self.rows: Array = np.zeros((rows, width))
        self.count = 0
        self._taken = 0

    def publish(self) -> None:
        """Note that the next row was filled."""
        self.count += 1

    def take(self) -> Array:
        """Return the rows since the last time, oldest first, shape (n, width): all, if taken in time.

        They are as they are until others are written.
        """
        size, first = len(self.rows), max(self._taken, self.count - len(self.rows))
        begin, end = first % size, first % size + self.count - first
        self._taken = self.count
        return self.rows[begin:end] if end <= size else np.concatenate((self.rows[begin:], self.rows[: end - size]))


class TableReader:
    """A reader; one per process or thread."""

    def __init__(self, segment: Segment) -> None:
        self._segment, self._words = segment, segment.words
        self._rows = _rows(segment)

    @classmethod
    def open(cls, path: Path) -> Self:
        """Map a table for reading only.

        Raises:
            LinkError: there is none.
        """
        return cls(_open(path, write=False))

    @property
    def count(self) -> int:
        """How many rows were published."""
        return self._words[_COUNT]

    @property
    def has_writer(self) -> bool:
        """Whether a process that lives has it open for writing."""
        return self._segment.has_writer

    def since(self, count: int) -> tuple[Array, int]:
        """Return copies of the rows that were published after the first ``count``, oldest first, and how many are lost.

        Returns:
            shape (n, width), and the number of rows that the writer overwrote before they were read.
        """
        kept = len(self._rows) - _SPARE
        end = self.count
        first = max(count, end - kept)
        copies = self._rows[np.arange(first, end) % len(self._rows)]
        still = max(first, self.count - kept)  # the writer went on
        return copies[still - first :], still - count

    def close(self) -> None:
        """Let go of the table."""
        del self._rows
        self._segment.close()


def _rows(segment: Segment) -> Array:
    width, rows = segment.info(0), segment.info(1)
    return np.frombuffer(segment.bytes, np.float64, rows * width, _FIRST_ROW).reshape(rows, width)


def _open(path: Path, write: bool) -> Segment:
    segment = Segment.open(path, Kind.TABLE, write)
    width, rows = segment.info(0), segment.info(1)
    if not width or rows < _MIN_ROWS or _FIRST_ROW + rows * width * WORD != len(segment.bytes):
        segment.close()
        raise LinkError(f"{path} is a damaged table")
    return segment
