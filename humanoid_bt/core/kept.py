"""Lists that hours of events do not fill the memory with."""

from __future__ import annotations

from typing import TypeVar

Entry = TypeVar("Entry")

MOST = 20_000
"""Entries that are kept where nothing else is said."""


class Kept(list[Entry]):
    """A list that is appended to, and keeps its first half and its latest entries.

    Args:
        most: how many are kept at most.

    Attributes:
        left_out: how many between them were dropped.
        total: how many there ever were.
    """

    def __init__(self, most: int = MOST) -> None:
        super().__init__()
        self._half, self._few, self._most = most // 2, max(most // 10, 1), most
        self.left_out = self.total = 0

    def append(self, entry: Entry) -> None:
        """Add an entry; now and then older ones make room for it."""
        super().append(entry)
        self.total += 1
        if len(self) > self._most:
            del self[self._half : self._half + self._few]
            self.left_out += self._few

    def since(self, total: int) -> list[Entry]:
        """Return what was added after there were so many, oldest first."""
        new = self.total - total
        return self[max(len(self) - new, 0) :] if new else []
