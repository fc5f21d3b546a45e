"""Allowing warnings in the file they are about, by a comment with a reason.

    - reach: {target: target}  # allow no-time-limit: the operator ends it

    # allow no-time-limit, no-hysteresis: the operator ends it, and the percept is filtered
    - reach: {target: target}

The comment stands on the line of the finding, or alone on the lines directly above it. Errors cannot be allowed.
"""

from __future__ import annotations

import bisect
import io
import re
import tokenize
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import yaml

from humanoid_bt.checking.codes import ALLOWABLE, CODES
from humanoid_bt.core.errors import Place, Problem, nearest

_BREAK = re.compile("\r\n|[\r\n\x85\u2028\u2029]")  # what YAML takes for the end of a line
_HEADER = re.compile(r"[|>][-+0-9]*[ \t]+(#)")  # of a block of text: a comment may stand behind it
_ALLOW = re.compile(r"#\s*allow\s+(\S.*)")
_WORD = re.compile(r"[\w-]+")


@dataclass(frozen=True)
class Comment:
    """A comment of a file.

    Attributes:
        line, column: where its ``#`` stands, counted from 1.
        text: from its ``#`` to the end of the line.
        alone: whether nothing stands before it on its line.
    """

    line: int
    column: int
    text: str
    alone: bool


@dataclass(frozen=True)
class _Allowance:
    place: Place
    codes: tuple[str, ...]
    line: int  # the line whose findings it allows


def remaining(source: str, file: str, problems: Sequence[Problem], *, complete: bool = True) -> list[Problem]:
    """Return what remains of a load's findings when the comments of one file have been heard.

    Args:
        source: the file's text; Python where its name ends in ``.py``, else YAML.
        file: its name, as in the findings' places.
        problems: the findings, also those in other files: they remain.
        complete: whether the findings are all there are: a comment that allows none of them is one more then.

    Returns:
        The findings that are not allowed in their order, then what is wrong with the comments.
    """
    mistakes: list[Problem] = []
    heard = comments(source, python=file.endswith(".py")) if "allow" in source else []
    allowances = list(_allowances(heard, file, mistakes))
    used: set[tuple[Place, str]] = set()
    rest: list[Problem] = []
    for problem in problems:
        by = [
            allowance.place
            for allowance in allowances
            if problem.severity == "warning"
            and problem.place is not None
            and (problem.place.file, problem.place.line) == (file, allowance.line)
            and problem.code in allowance.codes
        ]
        used.update((place, problem.code) for place in by)
        if not by:
            rest.append(problem)
    for allowance in allowances if complete else ():
        for code in allowance.codes:
            if (allowance.place, code) not in used:
                message = f"{code!r} is allowed here and does not occur"
                mistakes.append(Problem(message, allowance.place, "remove it", "unused-allow", "warning"))
    return rest + mistakes


def comments(source: str, *, python: bool = False) -> list[Comment]:
    """Return the comments of a file, as far as it can be read."""
    return list(_python_comments(source) if python else _yaml_comments(source))


def _allowances(found: Sequence[Comment], file: str, mistakes: list[Problem]) -> Iterator[_Allowance]:
    alone = {comment.line for comment in found if comment.alone}
    for comment in found:
        match = _ALLOW.match(comment.text)
        if match is None:
            continue
        place = Place(file, comment.line, comment.column)
        names, reason = _parts(match[1])
        if not names:
            continue
        if not reason and any(name in CODES for name in names):
            allowed, hint = ", ".join(map(repr, names)), f"write why: # allow {', '.join(names)}: ..."
            mistakes.append(Problem(f"{allowed} is allowed without a reason", place, hint, "allow-without-reason"))
        mistakes += filter(None, map(partial(_mistake, place), names))
        line = comment.line
        while line in alone:
            line += 1
        codes = tuple(name for name in names if name in ALLOWABLE and reason)
        yield _Allowance(place, codes, line)


def _parts(text: str) -> tuple[tuple[str, ...], str]:
    """Return the codes that a comment allows, and why; no codes if it is no more than a sentence that begins so."""
    head, colon, reason = text.partition(":")
    names = tuple(dict.fromkeys(name.strip() for name in head.split(",") if name.strip()))
    words = all(_WORD.fullmatch(name) for name in names)
    if words and (colon or any(_is_like_a_code(name) for name in names)):
        return names, reason.strip()
    first = _WORD.match(text)
    return ((first[0],), "") if first and not words and first[0] in CODES else ((), "")


def _is_like_a_code(name: str) -> bool:
    return name in CODES or nearest(name, CODES).startswith("did you mean")


def _mistake(place: Place, name: str) -> Problem | None:
    if name not in CODES:
        return Problem(f"there is no code {name!r}", place, nearest(name, ALLOWABLE), "unknown-code", "warning")
    if name in ALLOWABLE:
        return None
    error = CODES[name].severity == "error"
    message = f"{name!r} is an error, and errors cannot be allowed" if error else f"{name!r} cannot be allowed"
    return Problem(
        message, place, "correct what it is about: safety is not negotiable" if error else "", "cannot-allow"
    )


def _yaml_comments(source: str) -> Iterator[Comment]:
    """Yield the comments of a YAML text: they begin at a ``#`` that lies in none of the scanner's tokens."""
    starts = [0, *(match.end() for match in _BREAK.finditer(source))]
    before = 0  # end of what lies in a token or a comment
    for begin, end in _token_spans(source):
        while (at := source.find("#", before, begin)) >= 0:
            number = bisect.bisect_right(starts, at)
            match = _BREAK.search(source, at)
            before = match.start() if match else len(source)
            blank = not source[starts[number - 1] : at].strip(" \t\ufeff")
            yield Comment(number, at - starts[number - 1] + 1, source[at:before], blank)
        before = max(before, end)


def _token_spans(source: str) -> Iterator[tuple[int, int]]:
    """Yield where the tokens of a YAML text begin and end, up to the first mistake."""
    try:
        for token in yaml.scan(source, yaml.SafeLoader):
            begin, end = token.start_mark.index, token.end_mark.index
            if (
                isinstance(token, yaml.ScalarToken)
                and token.style in ("|", ">")
                and (header := _HEADER.match(source, begin))
            ):
                yield begin, header.start(1)
                match = _BREAK.search(source, begin)
                begin = match.start() if match else end
            yield begin, end
    except (yaml.YAMLError, ValueError, OverflowError):  # the finding "syntax" tells of it
        return


def _python_comments(source: str) -> Iterator[Comment]:
    try:
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type == tokenize.COMMENT:
                line, column = token.start
                yield Comment(line, column + 1, token.string, not token.line[:column].strip())
    except (tokenize.TokenError, SyntaxError):  # the finding "broken-skill" tells of it
        return
