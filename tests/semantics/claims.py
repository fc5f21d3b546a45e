"""The claims of docs/semantics.md, and which tests show them."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

PAGE = Path(__file__).parents[2] / "docs" / "semantics.md"

_CLAIM = re.compile(r"<!-- claim: ([a-z-]+) -->")

Test = TypeVar("Test", bound=Callable[..., object])


def shows(*claims: str) -> Callable[[Test], Test]:
    """Say which claims of the page a test shows."""

    def mark(test: Test) -> Test:
        vars(test)["shows"] = claims
        return test

    return mark


@dataclass(frozen=True)
class Piece:
    """A list item, a row of a table or a paragraph of the page.

    Attributes:
        line: where it begins, from 1.
        kind: ``item``, ``row`` or ``paragraph``.
        text: what it says, without the comments.
        claims: the ids in it.
    """

    line: int
    kind: str
    text: str
    claims: tuple[str, ...]


def pieces(text: str) -> list[Piece]:
    """Return what the page says below its first section heading, piece by piece."""
    lines = text.splitlines()
    first = next(number for number, line in enumerate(lines) if line.startswith("## "))
    found: list[Piece] = []
    block: list[str] = []
    start = 0

    def finish() -> None:
        if block:
            found.append(_piece(start + 1, " ".join(block)))
            block.clear()

    for number, line in enumerate(lines[first:], first):
        begins = line.startswith(("- ", "|"))
        if begins or not line.strip() or line.startswith("#"):
            finish()
        if line.strip() and not line.startswith("#"):
            if not block:
                start = number
            block.append(line.strip())
    finish()
    header = {piece.line - 1 for piece in found if re.fullmatch(r"[|\s:-]+", piece.text)}
    return [piece for piece in found if piece.line not in header and piece.line - 1 not in header]


def _piece(line: int, text: str) -> Piece:
    kind = "item" if text.startswith("- ") else "row" if text.startswith("|") else "paragraph"
    plain = " ".join(_CLAIM.sub("", text).split())
    return Piece(line, kind, plain.removeprefix("- "), tuple(_CLAIM.findall(text)))
