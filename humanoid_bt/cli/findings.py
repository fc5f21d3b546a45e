"""How findings look: one line that editors and terminals can follow to its place, then what would be valid."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from rich.cells import cell_len
from rich.console import Console
from rich.text import Text

from humanoid_bt.cli.output import hanging, width
from humanoid_bt.document import read_text
from humanoid_bt.errors import Place, Problem, UserError

_COLORS = {"error": "bold red", "warning": "bold yellow"}
_INDENT = "    "


def print_findings(problems: Iterable[Problem], *, stderr: bool = False) -> None:
    """Print findings; on a terminal in color and with the lines they are about."""
    console = Console(stderr=stderr, highlight=False, soft_wrap=True)
    for problem in problems:
        console.print(_headline(problem))
        if console.is_terminal and problem.place:
            for line in excerpt(problem.place, width()):
                console.print(_marked(line, _COLORS[problem.severity]))
        for line in _printable(problem.hint).splitlines():
            for part in hanging(_INDENT, line) if console.is_terminal else [_INDENT + line]:
                console.print(Text(part))


def counted(problems: Iterable[Problem]) -> str:
    """Return how many findings there are: ``3 errors, 2 warnings``."""
    numbers = Counter(problem.severity for problem in problems)
    return ", ".join(several(numbers[kind], kind) for kind in ("error", "warning") if numbers[kind])


def several(number: int, noun: str) -> str:
    """Return a number of things: ``1 file``, ``2 files``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def excerpt(place: Place, columns: int) -> list[str]:
    """Return the line of a file that a place is in and a mark below its column; nothing if it cannot be read.

    Args:
        place: the place.
        columns: the room there is; of a longer line, the part around the place is shown.
    """
    try:
        line = read_text(Path(place.file)).split("\n")[place.line - 1] if place.line else ""
    except (UserError, IndexError):
        return []
    text = "".join(letter if letter.isprintable() else " " for letter in line)
    at = max(place.column - 1, 0)
    if not text.strip() or at > len(text):
        return []
    gutter = f"{place.line:>5} | "
    text, at = _window(text, at, max(columns - len(gutter), 20))
    return [f"{gutter}{text.rstrip()}", f"{' ' * 5} | {' ' * cell_len(text[:at])}^"]


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


def _marked(line: str, color: str) -> Text:
    text = Text(line, "dim")
    if line.endswith("^") and not line[:-1].strip(" |"):
        text.stylize(f"not dim {color}", len(line) - 1)
    return text


def _printable(text: str) -> str:
    """Return a text in which a terminal finds no commands."""
    return "".join(letter if letter.isprintable() or letter == "\n" else repr(letter)[1:-1] for letter in text)


def _headline(problem: Problem) -> Text:
    message = _printable(problem.message).replace("\n", "\n" + _INDENT)
    return Text.assemble(
        (f"{problem.place}: " if problem.place else "", "bold"),
        (f"{problem.severity}: ", _COLORS[problem.severity]),
        message,
        (f" [{problem.code}]" if problem.code else "", "dim"),
    )
