"""Where the command line writes: streams that outlive their reader and pass on no commands, columns of any width."""

from __future__ import annotations

import errno
import io
import os
import shutil
import sys
import textwrap
from collections.abc import Iterable, Sequence
from typing import Any, TextIO, cast

from humanoid_bt.core.texts import printable

_GONE = {errno.EPIPE, errno.EIO}  # the reader has ended: a closed pipe, a closed terminal
_NARROWEST = 20  # columns that a text needs to be readable beside others

_PLAIN = str.maketrans(
    {"▶": ">", "→": ">", "✓": "+", "✗": "x", "○": "o", "■": "#", "•": "*", "├": "|", "└": "`", "─": "-", "│": "|"}
)
"""Signs for terminals that have only ASCII."""


class Lasting(io.TextIOBase):
    """A text stream that goes mute when its reader is gone: a robot does not stop for that.

    Args:
        stream: where the text goes; None for nowhere.

    Attributes:
        problem: why something could not be written, "" if it could or nobody would have read it.
    """

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream
        self.problem = ""
        self._plain = stream is not None and not _can_show(stream)
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")

    @property
    def encoding(self) -> str:  # type: ignore[override]  # an attribute there
        """The stream's encoding."""
        return str(getattr(self._stream, "encoding", None) or "utf-8")

    def write(self, text: str) -> int:
        """Write a text if it can be written."""
        if self._stream is not None:
            try:
                self._stream.write(text.translate(_PLAIN) if self._plain else text)
            except OSError as error:
                self._mute(error)
        return len(text)

    def flush(self) -> None:
        """Write out what is buffered."""
        if self._stream is not None:
            try:
                self._stream.flush()
            except OSError as error:
                self._mute(error)

    def isatty(self) -> bool:
        """Return whether it is a terminal."""
        return self._stream is not None and self._stream.isatty()

    def fileno(self) -> int:
        """Return the file's number."""
        if self._stream is None:
            raise OSError("no file")
        return self._stream.fileno()

    def writable(self) -> bool:
        """Return True."""
        return True

    def _mute(self, error: OSError) -> None:
        if error.errno not in _GONE:
            self.problem = error.strerror or type(error).__name__
        stream, self._stream = self._stream, None
        if stream is not None:
            # what is left in its buffer goes nowhere too, instead of into an exception at exit
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, stream.fileno())
            os.close(nowhere)


class Safe:
    """A text stream for text of any origin: a terminal finds no commands in it, whoever redirects it.

    Args:
        raw: where the text goes; for who makes commands of its own.
    """

    def __init__(self, raw: TextIO) -> None:
        self.raw = raw

    def write(self, text: str) -> int:
        """Write a text, with what a terminal would obey written out."""
        self.raw.write(printable(text))
        return len(text)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.raw, name)


def width() -> int:
    """Return the columns of the terminal, 80 if there is none."""
    return shutil.get_terminal_size((80, 24)).columns


def columns(rows: Iterable[Sequence[str]], *, indent: int = 0, first: int = 0) -> list[str]:
    """Return rows of columns as lines; the last column is wrapped, below the others where there is no room beside.

    Of a single row it stands below if one of its words, such as a path, has room only there.

    Args:
        rows: texts of equal number.
        indent: blanks before every line.
        first: least width of the first column.
    """
    table = [list(row) for row in rows]
    if not table:
        return []
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]) - 1)]
    widths[0] = max(widths[0], first)
    start = indent + sum(widths) + 2 * len(widths)
    room = width() - start
    lines: list[str] = []
    for *cells, text in table:
        head = " " * indent + "".join(f"{cell:<{size}}  " for cell, size in zip(cells, widths, strict=True))
        longest = max(map(len, text.split()), default=0)
        if room >= _NARROWEST and room < longest <= width() - indent - 4:
            lines += [head, *hanging(" " * (indent + 4), text)]
        elif room >= _NARROWEST:
            lines += hanging(head, text)
        else:
            lines += hanging(f"{'':{indent}}{cells[0]:<{widths[0]}}  ", "  ".join(filter(None, cells[1:])))
            lines += hanging(" " * (indent + 4), text) if text else []
    return lines


def hanging(head: str, text: str) -> list[str]:
    """Return a text after a head, wrapped to the terminal, its further lines below its first."""
    room = max(width() - len(head), _NARROWEST)
    wrapped = textwrap.wrap(text, room, break_long_words=False, break_on_hyphens=False) or [""]
    blank = " " * len(head)
    return [(head if number == 0 else blank) + line for number, line in enumerate(wrapped)]


def print_lines(lines: Iterable[Any]) -> None:
    """Print lines without trailing blanks."""
    for line in lines:
        print(str(line).rstrip())


def _can_show(stream: TextIO) -> bool:
    try:
        "▶├".encode(getattr(stream, "encoding", None) or "utf-8")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def standard_streams() -> tuple[Lasting, Lasting]:
    """Make standard output and standard error safe and lasting; return them."""
    out, err = Lasting(sys.stdout), Lasting(sys.stderr)
    make_safe(out, err)
    return out, err


def make_safe(out: Any, err: Any) -> None:
    """Let what is printed go to these two streams, without commands for terminals."""
    sys.stdout, sys.stderr = cast(TextIO, Safe(out)), cast(TextIO, Safe(err))
