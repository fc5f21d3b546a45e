"""Seeds as people write them: ``0-999``, ``3, 17, 100-199``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.items import Item

MOST = 1_000_000
"""Most seeds of a campaign."""

_RANGE = re.compile(r"(\d{1,18})(?:\s*-\s*(\d{1,18}))?")


@dataclass(frozen=True)
class Seeds:
    """Some seeds.

    Attributes:
        ranges: first and last of each range, in the order in which they are written; no seed is in two.
    """

    ranges: tuple[tuple[int, int], ...]

    described: ClassVar[str] = "seeds, as 0-999 or 3, 17, 100-199"
    """What they are called in messages."""

    @classmethod
    def from_item(cls, item: Item, name: str) -> Seeds:
        """Read seeds: a whole number, text, or a list of both.

        Raises:
            UserError: they are none.
        """
        parts = item.value if isinstance(item.value, list) else [item]
        texts = [str(part.value) for part in parts if isinstance(part.value, (int, str)) and part.value is not True]
        if len(texts) != len(parts) or not texts:
            raise UserError(f"{name!r} must be {cls.described}, not {item.kind}", item.place, code="wrong-type")
        try:
            return cls.read(", ".join(texts))
        except ValueError as error:
            raise UserError(f"{name!r}: {error}", item.place, cls.described, "wrong-type") from error

    @classmethod
    def read(cls, text: str) -> Seeds:
        """Read seeds from text.

        Raises:
            ValueError: it holds none, one twice, or too many.
        """
        ranges: list[tuple[int, int]] = []
        for part in text.split(","):
            match = _RANGE.fullmatch(part.strip())
            if match is None:
                raise ValueError(f"{part.strip()!r} is no seed and no range of seeds")
            first = int(match[1])
            last = int(match[2] or first)
            if last < first:
                raise ValueError(f"{part.strip()!r} runs down: the lower seed comes first")
            if any(first <= other_last and other_first <= last for other_first, other_last in ranges):
                raise ValueError(f"{part.strip()!r} has a seed that is there already")
            ranges.append((first, last))
        seeds = cls(tuple(ranges))
        if len(seeds) > MOST:
            raise ValueError(f"{len(seeds):,} seeds are more than the {MOST:,} that a campaign can have")
        return seeds

    def __len__(self) -> int:
        return sum(last - first + 1 for first, last in self.ranges)

    def __iter__(self) -> Iterator[int]:
        for first, last in self.ranges:
            yield from range(first, last + 1)

    def __str__(self) -> str:
        return ", ".join(str(first) if first == last else f"{first}-{last}" for first, last in self.ranges)
