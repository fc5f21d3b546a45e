"""How findings look: one line that editors and terminals can follow to its place, then what would be valid."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable

from humanoid_bt.core.errors import Problem

INDENT = "    "


def print_findings(problems: Iterable[Problem], *, stderr: bool = False) -> None:
    """Print findings; on a terminal in color and with the lines they are about."""
    stream = sys.stderr if stderr else sys.stdout
    if stream.isatty():
        from humanoid_bt.cli.excerpts import print_with_excerpts  # stopping a robot does not wait for this import

        print_with_excerpts(problems, stderr=stderr)
        return
    for problem in problems:
        print("".join(headline(problem)), file=stream)
        for line in printable(problem.hint).splitlines():
            print(INDENT + line, file=stream)


def headline(problem: Problem) -> tuple[str, str, str, str]:
    """Return the parts of a finding's first line: place, severity, message, code, each with what joins it."""
    return (
        f"{problem.place}: " if problem.place else "",
        f"{problem.severity}: ",
        printable(problem.message).replace("\n", "\n" + INDENT),
        f" [{problem.code}]" if problem.code else "",
    )


def printable(text: str) -> str:
    """Return a text in which a terminal finds no commands."""
    return "".join(letter if letter.isprintable() or letter == "\n" else repr(letter)[1:-1] for letter in text)


def counted(problems: Iterable[Problem]) -> str:
    """Return how many findings there are: ``3 errors, 2 warnings``."""
    numbers = Counter(problem.severity for problem in problems)
    return ", ".join(several(numbers[kind], kind) for kind in ("error", "warning") if numbers[kind])


def several(number: int, noun: str) -> str:
    """Return a number of things: ``1 file``, ``2 files``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
