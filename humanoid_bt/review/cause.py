"""A cause: one sentence for a person in a hurry, and what shows that it is true."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

Row = tuple[str, str]
"""What something is, and a text."""


@dataclass(frozen=True)
class Cause:
    """Why a run ended.

    Attributes:
        kind: what sort of cause it is, a name of :data:`~humanoid_bt.review.hints.HINTS`.
        headline: it in words, with time, node and quantity.
        time: the moment to look at [s].
        node: path of the node behind it, "" if there is none.
        rows: what shows it.
        began: when it began, if that was before [s].
    """

    kind: str
    headline: str
    time: float
    node: str = ""
    rows: list[Row] = field(default_factory=list)
    began: float | None = None


def unrepeated(rows: Iterable[Row]) -> Iterator[Row]:
    """Yield rows, the name of several in a row only once."""
    before = ""
    for name, text in rows:
        yield "" if name == before else name, text
        before = name
