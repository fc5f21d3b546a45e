"""One form for YAML files, in which every comment, value and key stays where it was put.

Only blanks between tokens are rewritten. The tokens are those of PyYAML, which also reads the files, and each is
written again as it stands in the source: a number, a quote, an anchor or a ``yes`` cannot change. A round trip
through an emitter does not give that: ruamel.yaml 0.19 loses comments inside of flow mappings and lists, writes ``~``
and ``Null`` as nothing, unescapes quoted text, joins lines, and reads YAML 1.2 where the files are YAML 1.1.

Line breaks are the author's. What is normalised:

- two columns per level; the items of a list stand two columns right of its key;
- one blank after ``:``, ``,``, ``-`` and ``?``; none before ``:`` and ``,``, and none inside of brackets;
- no blanks at the ends of lines, at most one empty line in a row, none at either end, a final line break;
- a comment on a line of its own stands like what it is about; where a block ends, its column says which block that is;
- comments at the ends of neighbouring lines stand in one column; those that already do keep their distance.
"""

from __future__ import annotations

import re

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.files.document import parse
from humanoid_bt.files.formatting.tokens import comments
from humanoid_bt.files.formatting.writer import write

__all__ = ["comments", "formatted"]

_OTHER_BREAK = re.compile("[\x85\u2028\u2029]")
"""What breaks lines for YAML 1.1 and for no editor."""


def formatted(text: str, name: str) -> str:
    """Return YAML text in the one form, its lines ending in LF; formatting it again changes nothing.

    Args:
        text: the YAML text.
        name: the file's name, for messages.

    Raises:
        UserError: the text cannot be read, as :func:`humanoid_bt.files.document.parse` says it, breaks lines with other
            characters than CR and LF, or the result would differ from it in more than blanks.
    """
    text = text.removeprefix("\ufeff").replace("\r\n", "\n").replace("\r", "\n")
    before = parse(text, name).plain()
    if other := _OTHER_BREAK.search(text):
        line, column = text.count("\n", 0, other.start()) + 1, other.start() - text.rfind("\n", 0, other.start())
        raise UserError(
            f"cannot be formatted: the character U+{ord(other[0]):04X} breaks a line here",
            Place(name, line, column),
            "break the line as the others, or write it as an escape in double quotes",
        )
    result = write(text)
    if result != text and not _is_same(text, result, before):
        raise UserError(
            "it cannot be formatted without changing what it says, and is left as it was",
            Place(name),
            "please report it with the file",
        )
    return result


def _is_same(text: str, result: str, before: object) -> bool:
    """Return whether a result has the characters, comments and values of a text; nothing leaves without this."""
    if "".join(text.split()) != "".join(result.split()):
        return False
    try:
        after = parse(result, "").plain()
    except UserError:
        return False
    return repr(after) == repr(before) and comments(result) == comments(text)  # repr: 1 is not true, nan is nan
