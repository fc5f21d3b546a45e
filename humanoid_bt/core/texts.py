"""Text from elsewhere (files, skills, exceptions, other processes) before people read it."""

from __future__ import annotations

import re
from collections.abc import Sequence

LONGEST_TEXT = 4000
"""Characters that are kept of what a node, an event or an exception says."""

_COMMANDS = re.compile(
    "\r(?!\n)|["
    "\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f"  # what terminals obey; a line break and a tab do no harm
    "\u061c\u200b\u200e\u200f\u202a-\u202e\u2060-\u206f\ufff9-\ufffb\U000e0000-\U000e007f"  # order, nothing seen
    "\u2028\u2029\ud800-\udfff\ufffe\uffff"  # other line breaks; bytes of a file name that are no text; no characters
    "]"
)


def printable(text: str) -> str:
    r"""Return a text in which a terminal finds no commands: they are written out, as ``\x1b``."""
    return _COMMANDS.sub(lambda found: ascii(found[0])[1:-1], text)


def one_line(text: str) -> str:
    """Return a text as :func:`printable` does, with its line breaks and tabs as blanks."""
    return printable(re.sub(r"\s", " ", text))


def told(error: BaseException) -> str:
    """Return the kind of an exception and its text, whatever making that text does."""
    try:
        text = str(error)
    except Exception as second:
        text = f"(its text cannot be made: {type(second).__name__})"
    return f"{type(error).__name__}: {text}"


def listed(names: Sequence[str]) -> str:
    """Return names as in a sentence: ``a``, ``a and b``, ``a, b and c``."""
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def few(texts: Sequence[str], most: int) -> list[str]:
    """Return at most so many of some texts; the last one says how many more there are."""
    return list(texts) if len(texts) <= most else [*texts[: most - 1], f"{len(texts) - most + 1} more"]


def shortened(text: object, longest: int = LONGEST_TEXT) -> str:
    """Return a text, or the text of what should be one, in at most so many characters; that it is cut is told."""
    whole = text if isinstance(text, str) else str(text)
    if len(whole) <= longest:
        return whole
    note = f"… ({len(whole):,} characters)"
    return whole[: longest - len(note)] + note


def snake_case(name: str) -> str:
    """Return a CamelCase name as it is written in files."""
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()
