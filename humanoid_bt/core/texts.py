"""Text from elsewhere (files, skills, exceptions, other processes) before people read it."""

from __future__ import annotations

import difflib
import re
import traceback
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
    """Return the kind of an exception, its text, whatever making that text does, and the name that was meant."""
    try:
        text = str(error)
    except Exception as second:
        text = f"(its text cannot be made: {type(second).__name__})"
    return "; ".join(filter(None, [f"{type(error).__name__}: {text}", meant(error)]))


def meant(error: BaseException) -> str:
    """Return what is nearest to a name that is not there: ``did you mean 'move_hand'?``, "" if nothing is near."""
    name = getattr(error, "name", None)
    if not isinstance(error, (AttributeError, NameError)) or not isinstance(name, str):
        return ""
    try:
        names = dir(error.obj) if isinstance(error, AttributeError) else _names_at(error)
    except Exception:  # the object's own code; one that was never raised has been nowhere
        return ""
    if f"self.{name}" in names:
        return f"did you mean 'self.{name}'?"
    texts = [one for one in names if isinstance(one, str)]  # an object may say that it has others
    public = [one for one in texts if name.startswith("_") or not one.startswith("_")]
    close = difflib.get_close_matches(name, public, n=1)
    return f"did you mean {close[0]!r}?" if close and name not in names else ""


def _names_at(error: BaseException) -> list[str]:
    """Return the names that there are where an exception was raised, and the attributes of ``self``."""
    *_, (frame, _line) = traceback.walk_tb(error.__traceback__)
    own = [f"self.{name}" for name in dir(frame.f_locals["self"])] if "self" in frame.f_locals else []
    return [*frame.f_locals, *frame.f_globals, *frame.f_builtins, *own]


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
