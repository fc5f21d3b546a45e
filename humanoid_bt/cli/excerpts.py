"""Findings on a terminal: in color, with the line each is about, and hints that fit."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from rich.cells import cell_len
from rich.text import Text

from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.output import hanging, width
from humanoid_bt.cli.wording import INDENT, headline
from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.texts import printable
from humanoid_bt.files.reading import read_text

_COLORS = {"error": "bold red", "warning": "bold yellow"}
_LEAST = 20  # columns of a file's line that are shown in any case


def print_with_excerpts(problems: Iterable[Problem], *, stderr: bool) -> None:
    """Print findings, each with the line it is about and a mark below its column."""
    console = SafeConsole(stderr=stderr, soft_wrap=True)
    for problem in problems:
        color = _COLORS[problem.severity]
        place, severity, message, code = headline(problem)
        head = Text.assemble((place, "bold"), (severity, color), message, (code, "dim"))
        first, *others = head.wrap(console, max(width() - len(INDENT), _LEAST), overflow="fold")
        for part in (first, *(Text(INDENT).append_text(other) for other in others)):
            part.rstrip()
            console.print(part)
        if problem.place and (lines := excerpt(problem.place, width())):
            line, mark = lines
            console.print(Text(line, "dim"))
            console.print(Text.assemble((mark[:-1], "dim"), (mark[-1], color)))
        for line in printable(problem.hint).splitlines():
            for words in hanging(INDENT, line):
                console.print(Text(words))


def excerpt(place: Place, columns: int) -> tuple[str, str] | None:
    """Return the line of a file that a place is in, and a line with a mark below its column; None without one.

    Args:
        place: the place.
        columns: the room there is; of a longer line, the part around the place is shown.
    """
    try:
        line = read_text(Path(place.file)).split("\n")[place.line - 1] if place.line else ""
    except (UserError, IndexError):
        return None
    text = "".join(letter if letter.isprintable() else " " for letter in line)
    at = max(place.column - 1, 0)
    if not text.strip() or at > len(text):
        return None
    gutter = f"{place.line:>5} | "
    text, at = _window(text, at, max(columns - len(gutter), _LEAST))
    below = " " * (len(gutter) - 2) + "| "
    return f"{gutter}{text.rstrip()}", f"{below}{' ' * cell_len(text[:at])}^"


def _window(text: str, at: int, room: int) -> tuple[str, int]:
    """Return the part of a text around an index that fits, and the index in it."""
    if len(text) <= room:
        return text, at
    begin = 0 if at < room - 8 else at - room // 2
    end = begin + room
    shown = text[begin:end]
    if end < len(text):
        shown = shown[:-3] + "..."
    if begin:
        shown = "..." + shown[3:]
    return shown, at - begin
