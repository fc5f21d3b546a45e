"""A counter that a loop bumps after each completed round, and that control reads to see whether it still turns."""

from __future__ import annotations

from pathlib import Path
from typing import Self

from humanoid_bt.link.segment import HEADER, WORD, Kind, Segment

_COUNT = HEADER // WORD
_SIZE = 2 * HEADER


class Heartbeat:
    """One loop's counter: one process beats, any number read. Made by :meth:`create` and :meth:`open`."""

    def __init__(self, segment: Segment) -> None:
        self._segment, self._words = segment, segment.words

    @classmethod
    def create(cls, path: Path) -> Self:
        """Make a counter that stands at 0.

        Raises:
            LinkError: the file cannot be made.
        """
        return cls(Segment.create(path, Kind.HEARTBEAT, _SIZE))

    @classmethod
    def open(cls, path: Path) -> Self:
        """Map a counter; a loop that starts again goes on counting where the last one stopped.

        Raises:
            LinkError: there is none.
        """
        return cls(Segment.open(path, Kind.HEARTBEAT, write=True))

    def beat(self, rounds: int = 1) -> None:
        """Count completed rounds; others see all of them at once."""
        self._words[_COUNT] += rounds

    @property
    def count(self) -> int:
        """Rounds completed so far."""
        return self._words[_COUNT]

    def close(self) -> None:
        """Let go of the counter."""
        self._segment.close()
