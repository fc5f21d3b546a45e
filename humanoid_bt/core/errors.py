"""Errors: one base class, and messages that say what, where and what would be valid."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from humanoid_bt.core.texts import printable

Severity = Literal["error", "warning"]
"""An error keeps a file from being used; a warning does not."""


@dataclass(frozen=True)
class Place:
    """A position in a file; line and column count from 1, 0 means unknown."""

    file: str
    line: int = 0
    column: int = 0

    def __str__(self) -> str:
        if not self.line:
            return self.file
        return f"{self.file}:{self.line}:{self.column}"


@dataclass(frozen=True)
class Problem:
    """One mistake: what is wrong, where, and what would be valid.

    Attributes:
        message: what is wrong.
        place: where.
        hint: what would be valid.
        code: stable name of this kind of mistake, for programs and for allowing it; "" where it has none.
        severity: an error keeps a file from being used, a warning does not.
    """

    message: str
    place: Place | None = None
    hint: str = ""
    code: str = ""
    severity: Severity = "error"

    def __str__(self) -> str:
        where = f"{self.place}: " if self.place else ""
        code = f" [{self.code}]" if self.code else ""
        hint = f"\n    {self.hint}" if self.hint else ""
        return printable(f"{where}{self.severity}: {self.message}{code}{hint}")


class HumanoidBtError(Exception):
    """Base of every error this package raises on purpose."""


class UserError(HumanoidBtError, ValueError):
    """A mistake in what the user gave: a file, a name, a value, a flag.

    Its text tells every mistake; warnings that were found with them are only in ``problems``.

    Args:
        problems: every mistake found, or the message of the only one.
        place: where it is, for a single message.
        hint: what would be valid, for a single message.
        code: stable name of this kind of mistake, for a single message.
    """

    def __init__(
        self, problems: str | Sequence[Problem], place: Place | None = None, hint: str = "", code: str = ""
    ) -> None:
        self.problems: tuple[Problem, ...] = (
            (Problem(problems, place, hint, code),) if isinstance(problems, str) else tuple(problems)
        )
        mistakes = [problem for problem in self.problems if problem.severity == "error"]
        super().__init__("\n".join(map(str, mistakes or self.problems)))


class ControlLost(HumanoidBtError):  # noqa: N818 (the name says it)
    """The process that controls the robot is gone: nobody can command the robot any more."""


class ResourceConflict(HumanoidBtError):  # noqa: N818 (the name says it)
    """Two living nodes commanded one resource in the same tick."""


_FEW, _NEAREST = 12, 5
"""Most names that a hint lists all, and how many of more."""


def nearest(name: str, valid: Iterable[str], command: str = "") -> str:
    """Return a hint: the nearest valid name if one is close, and the valid ones if they are few.

    Args:
        name: what was given.
        valid: what would be valid.
        command: what lists all of them.
    """
    names = sorted(set(valid))
    if not names:
        return ""
    close = difflib.get_close_matches(name, names, n=1, cutoff=0.6)
    if len(names) <= _FEW:
        return (f"did you mean {close[0]!r}? " if close else "") + f"valid: {', '.join(names)}"
    if close:
        return f"did you mean {close[0]!r}?"
    some = ", ".join(difflib.get_close_matches(name, names, n=_NEAREST, cutoff=0.0))
    return f"the nearest of {len(names)}: {some}" + (f"; all: {command}" if command else "")


def any_of(names: Sequence[str]) -> str:
    """Return names as a choice: ``'a' or 'b'``, of many the first few."""
    if len(names) > _NEAREST:
        return ", ".join(map(repr, names[:_NEAREST])) + f" or {len(names) - _NEAREST} others"
    return " or ".join(filter(None, [", ".join(map(repr, names[:-1])), *map(repr, names[-1:])]))


def also_at(places: Sequence[Place]) -> str:
    """Return in which further lines a mistake stands, to be put behind a hint; "" for a single place."""
    lines = sorted({place.line for place in places[1:] if place.file == places[0].file} - {places[0].line})
    return f"; also in line{'s' * (len(lines) > 1)} {', '.join(map(str, lines))}" if lines else ""


def relative(path: Path) -> str:
    """Return a path as people read it: relative to the working directory if it lies below it, a link by its name."""
    for find in (Path.absolute, resolved):
        try:
            below = find(path).relative_to(Path.cwd())
        except (ValueError, OSError):
            continue
        if ".." not in below.parts:
            return str(below)
    return str(path)


def resolved(path: Path) -> Path:
    """Return an absolute path without links; as it is where these lead in a circle, or nobody can follow it.

    Raises:
        UserError: it is relative to a working directory that is gone.
    """
    try:
        return path.resolve()
    except (RuntimeError, OSError, ValueError):
        pass
    try:
        return path.absolute()
    except FileNotFoundError:
        hint = "cd to a folder that is there"
        raise UserError("the working directory is gone", hint=hint, code="no-file") from None
