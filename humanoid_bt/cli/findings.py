"""Findings as lines: one that editors and terminals can follow to its place, then what would be valid."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterable

from humanoid_bt.cli.wording import INDENT, headline, several
from humanoid_bt.core.errors import Problem
from humanoid_bt.core.texts import printable


def print_findings(problems: Iterable[Problem], *, stderr: bool = False) -> None:
    """Print findings; on a terminal in color and with the lines they are about."""
    stream = sys.stderr if stderr else sys.stdout
    if stream.isatty():
        from humanoid_bt.cli.excerpts import print_with_excerpts

        print_with_excerpts(problems, stderr=stderr)
        return
    for problem in problems:
        print("".join(headline(problem)), file=stream)
        for line in printable(problem.hint).splitlines():
            print(INDENT + line, file=stream)


def counted(problems: Iterable[Problem]) -> str:
    """Return how many findings there are: ``3 errors, 2 warnings``."""
    numbers = Counter(problem.severity for problem in problems)
    return ", ".join(several(numbers[kind], kind) for kind in ("error", "warning") if numbers[kind])
