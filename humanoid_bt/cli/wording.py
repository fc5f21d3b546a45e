"""How things are worded for terminals: the first line of a finding, numbers of things."""

from __future__ import annotations

from humanoid_bt.core.errors import Problem
from humanoid_bt.core.texts import one_line, printable

INDENT = "    "


def headline(problem: Problem) -> tuple[str, str, str, str]:
    """Return the parts of a finding's first line: place, severity, message, code, each with what joins it."""
    return (
        f"{one_line(str(problem.place))}: " if problem.place else "",
        f"{problem.severity}: ",
        printable(problem.message).replace("\n", "\n" + INDENT),
        f" [{problem.code}]" if problem.code else "",
    )


def several(number: int, noun: str) -> str:
    """Return a number of things: ``1 file``, ``2 files``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
