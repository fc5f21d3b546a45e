"""Lines with comments at their ends, and aligning these."""

from __future__ import annotations

import unicodedata
from collections.abc import Iterable
from dataclasses import dataclass

WIDTH = 100
"""Column beyond which no comment is moved only to stand below another."""

DISTANCE = 2
"""Least blanks before a comment at the end of a line."""


@dataclass(frozen=True)
class Line:
    """A line to be written.

    Attributes:
        text: what it holds, its comment left out; "" for a line that goes on with the comment above.
        comment: the comment at its end.
        source_width: columns that the text took in the source.
        source_column: where the comment stood in the source.
    """

    text: str
    comment: str = ""
    source_width: int = 0
    source_column: int = 0


def display_width(text: str) -> int:
    """Return how many columns a text takes in a terminal or an editor."""
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return len(text) + wide - sum(unicodedata.combining(character) > 0 for character in text)


def aligned(lines: Iterable[Line]) -> list[str]:
    """Return lines as text, the comments at the ends of neighbouring lines in one column."""
    texts: list[str] = []
    block: list[Line] = []
    for line in lines:
        if line.comment:
            block.append(line)
        else:
            texts += [*_block(block), line.text]
            block = []
    return texts + _block(block)


def _block(lines: list[Line]) -> list[str]:
    if not lines:
        return []
    widths = [display_width(line.text) for line in lines]
    if len({line.source_column for line in lines}) == 1:
        distance = lines[0].source_column - max(line.source_width for line in lines)
        columns = [max(widths) + max(distance, DISTANCE)] * len(lines)
    else:
        columns = _columns(lines, widths)
    return [
        line.text + " " * (column - width) + line.comment
        for line, width, column in zip(lines, widths, columns, strict=True)
    ]


def _columns(lines: list[Line], widths: list[int]) -> list[int]:
    """Return the columns of comments that did not stand in one."""
    common = max(widths) + DISTANCE
    if all(
        common + display_width(line.comment) <= WIDTH or common == width + DISTANCE
        for line, width in zip(lines, widths, strict=True)
    ):
        return [common] * len(lines)
    columns: list[int] = []
    for line, width in zip(lines, widths, strict=True):
        columns.append(width + DISTANCE if line.text or not columns else columns[-1])
    return columns
