"""How wide text is in a picture, without a font at hand, and where to break it."""

from __future__ import annotations

import unicodedata

FONT = "Helvetica, Arial, 'Liberation Sans', sans-serif"
"""Typefaces of one width on every system; the widths below are theirs."""

_WIDTHS = {  # thousandths of the size -> characters, from the Adobe font metrics of Helvetica
    191: "'",
    222: "ijl",
    260: "|",
    278: " !,./:;I[\\]ft",
    333: "()-`r{}",
    355: '"',
    389: "*",
    469: "^",
    500: "Jckvsxyz",
    556: "#$0123456789?L_abdeghnopqu",
    584: "+<=>~",
    611: "FTZ",
    667: "&ABEKPSVXY",
    722: "CDHNRUw",
    778: "GOQ",
    833: "Mm",
    889: "%",
    944: "W",
    1015: "@",
}
_WIDTH = {character: width for width, characters in _WIDTHS.items() for character in characters}
_OTHER, _WIDE = 720, 1000  # of most letters beyond ASCII, and of those of East Asia
_BOLD = 1.09  # bold text is wider by this, on average of the letters
_SOFT = "_-./,:"  # a long word may be broken after these


def text_width(text: str, size: float, bold: bool = False) -> float:
    """Return about how wide a text is, in the unit of its size."""
    thousandths = sum(map(_character_width, text))
    return thousandths / 1000 * size * (_BOLD if bold else 1.0)


def wrap(text: str, room: float, size: float, bold: bool = False) -> list[str]:
    """Break a text between words, and a word that is too long after a sign in it, or anywhere.

    Args:
        text: one line.
        room: how wide a line may be.
        size: of the letters.
        bold: whether they are bold.
    """
    lines = [""]
    for word in text.split():
        joined = f"{lines[-1]} {word}" if lines[-1] else word
        if text_width(joined, size, bold) <= room:
            lines[-1] = joined
            continue
        parts = _broken(word, room, size, bold)
        lines[-1:] = [lines[-1], *parts] if lines[-1] else parts
    return lines


def _broken(word: str, room: float, size: float, bold: bool) -> list[str]:
    parts: list[str] = []
    while text_width(word, size, bold) > room and len(word) > 1:
        fits = next(n for n in range(len(word) - 1, 0, -1) if n == 1 or text_width(word[:n], size, bold) <= room)
        soft = max(word.rfind(sign, fits // 2, fits) for sign in _SOFT) + 1
        cut = soft or fits
        parts.append(word[:cut])
        word = word[cut:]
    return [*parts, word]


def _character_width(character: str) -> int:
    if character in _WIDTH:
        return _WIDTH[character]
    if unicodedata.combining(character):
        return 0
    return _WIDE if unicodedata.east_asian_width(character) in "WF" else _OTHER
