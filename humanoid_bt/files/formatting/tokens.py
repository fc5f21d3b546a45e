"""The tokens of YAML text, and the blanks and comments between them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import yaml


@dataclass(frozen=True)
class Piece:
    """A token of a text.

    Attributes:
        token: what PyYAML found.
        start: where the gap begins in the text.
        gap: the blanks, line breaks and comments before the token.
        source: the token as it is written; "" for one that has no characters.
    """

    token: yaml.Token
    start: int
    gap: str
    source: str

    @property
    def is_block_scalar(self) -> bool:
        """Whether it is a literal (``|``) or folded (``>``) text."""
        return isinstance(self.token, yaml.ScalarToken) and self.token.style in ("|", ">")

    @property
    def header(self) -> tuple[str, str]:
        """Of a literal or folded text: its indicators, and the rest of their line."""
        line = self.source.partition("\n")[0]
        indicators = line.partition(" ")[0]
        return indicators, line[len(indicators) :]


def pieces(text: str) -> Iterator[Piece]:
    """Yield the tokens of YAML text whose lines end in LF; together, gaps and sources are the whole text.

    Raises:
        yaml.YAMLError: it is no valid YAML.
    """
    end = 0
    for token in yaml.scan(text, Loader=yaml.SafeLoader):
        start, stop = token.start_mark.index, token.end_mark.index
        if isinstance(token, yaml.StreamEndToken):
            start = stop = len(text)
        elif start == stop:
            yield Piece(token, end, "", "")
            continue
        if isinstance(token, yaml.DirectiveToken):  # its end leaves out words that PyYAML does not know
            stop = text.index("\n", stop)  # a marker of the document comes below
        yield Piece(token, end, text[end:start], text[start:stop])
        end = stop


def comments(text: str) -> list[str]:
    """Return the comments of YAML text in their order, without blanks at their ends.

    Raises:
        yaml.YAMLError: it is no valid YAML.
    """
    found: list[str] = []
    for piece in pieces(text):
        found += piece.gap.split("\n")
        if piece.is_block_scalar:
            found.append(piece.header[1])
    return [line.strip() for line in found if line.strip()]
