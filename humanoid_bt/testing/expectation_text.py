"""Reading expectations: from text, ``within 20 s: outcome == success``, or from YAML, as a key and a value."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item
from humanoid_bt.core.reading import is_finite
from humanoid_bt.testing.claim import Claim
from humanoid_bt.testing.expectation import AtEnd, Expectation, Order, Throughout, Within
from humanoid_bt.testing.step import Step
from humanoid_bt.tree.expressions.linking import CODE, is_constant, within
from humanoid_bt.tree.expressions.quantities import read_quantity

KINDS = ("within", "never", "always", "order")
"""With what an expectation begins that is not about the end."""

EXAMPLES = "like within 20 s: outcome == success, never: fell, always: P while Q, order: [approach, reach]"
MOST = 1000
"""Most expectations in one file."""

_QUOTED = r"'[^']*'|\"[^\"]*\""
_COLON, _COMMA = re.compile(rf"{_QUOTED}|(:)"), re.compile(rf"{_QUOTED}|[()]|(,)")
_WHILE, _AFTER = re.compile(rf"{_QUOTED}|\b(while)\b"), re.compile(r"\b(after)\b")


class _Text(NamedTuple):
    """A text and where it is written: its place, and how many columns behind that it begins, None if not known."""

    text: str
    place: Place
    at: int | None

    def part(self, begin: int, end: int | None = None) -> _Text:
        """Return a part of it, without blanks around."""
        inner = self.text[begin:end]
        begin += len(inner) - len(inner.lstrip())
        return _Text(inner.strip(), self.place, None if self.at is None else self.at + begin)

    def split(self, pattern: re.Pattern[str]) -> tuple[_Text, _Text | None]:
        """Return what stands before and behind the first match of a group; None without one.

        What is in quotes does not count, nor what is in parentheses, if the pattern matches these.
        """
        depth = 0
        for found in pattern.finditer(self.text):
            depth += {"(": 1, ")": -1}.get(found[0], 0)
            if found[1] and depth <= 0:
                return self.part(0, found.start()), self.part(found.end())
        return self.part(0), None

    def mistake(self, message: str, hint: str = "", at: int = 0) -> UserError:
        """Return an error about it."""
        return UserError(message, within(self.place, self.at, at), hint, CODE)

    @property
    def claim(self) -> Claim:
        """It as a claim; raises UserError."""
        claim = Claim.parse(*self)
        if is_constant(claim.syntax):
            raise self.mistake(f"{self.text!r} asks nothing of the run", EXAMPLES)
        return claim


def expectation(text: str) -> Expectation:
    """Return the expectation that a text says.

    Raises:
        UserError: it says none.
    """
    if not isinstance(text, str) or not text.strip():
        raise UserError(f"an expectation is text, not {text!r}", hint=EXAMPLES, code="wrong-type")
    return _of_text(_Text(text, Place("expectation", 1, 1), 0).part(0))


def _of_text(whole: _Text) -> Expectation:
    head, rest = whole.split(_COLON)
    if rest is None:
        return AtEnd(whole.text, whole.place, _claim_at_end(whole))
    steps = rest
    if head.text == "order" and rest.text[:1] + rest.text[-1:] == "[]":
        steps = rest.part(1, len(rest.text) - 1)
    return _of_kind(head, rest, list(_steps(steps)))


def _claim_at_end(whole: _Text) -> Claim:
    """Return the claim of an expectation without a kind; raises UserError, which knows a colon that was forgotten."""
    try:
        return whole.claim
    except UserError as error:
        kind, _, rest = whole.text.partition(" ")
        if kind == "within" and (time := read_quantity(whole.text, len("within "))):
            kind, rest = whole.text[: time[2]], whole.text[time[2] :].strip()
        if not rest or rest.startswith("after ") or _kind(whole) not in KINDS:
            raise
        hint = f'did you mean "{kind}: {rest}"?'
        raise UserError([replace(problem, hint=hint) for problem in error.problems]) from None


def expectations_in(item: Item, name: str) -> list[Expectation]:
    """Return the expectations of a YAML value: a list of texts and mappings, or one of these.

    Args:
        item: the value.
        name: of the parameter.

    Raises:
        UserError: with every mistake found.
    """
    problems: list[Problem] = []
    found: list[Expectation] = []
    for read in _entries(item, name):
        try:
            found.append(read())
        except UserError as error:
            problems += error.problems
        if len(found) > MOST:
            raise UserError(f"more than {MOST:,} expectations", item.place, code="too-large")
    if not found and not problems:
        raise _nothing(name, item)
    if problems:
        raise UserError(problems)
    return found


class _Entry(NamedTuple):
    """An expectation that is to be read: its key, None if it is about the end, and its value."""

    key: _Text | None
    value: Item
    name: str

    def __call__(self) -> Expectation:
        if self.key is None:
            return _of_text(_text(self.value, self.name))
        if _kind(self.key) == "order" and isinstance(self.value.value, list):
            steps = [_text(step, "a step") for step in self.value.value]
            return _of_kind(self.key, _Text(f"[{', '.join(step.text for step in steps)}]", *self.key[1:]), steps)
        if self.value.value == []:
            raise _nothing(self.key.text, self.value)
        value = _text(self.value, self.key.text)
        return _of_kind(self.key, value, list(_steps(value)))


def _entries(item: Item, name: str) -> Iterator[_Entry]:
    if isinstance(item.value, list):
        for part in item.value:
            yield from _entries(part, name) if isinstance(part.value, dict) else (_Entry(None, part, name),)
    elif isinstance(item.value, dict):
        for key, value in item.value.items():
            head = _Text(key, item.key_places[key], 0).part(0)
            several = isinstance(value.value, list) and not key.strip().startswith("order")
            parts = value.value if several else ()
            yield from (_Entry(head, part, name) for part in parts or (value,))
    else:
        yield _Entry(None, item, name)


def _nothing(name: str, item: Item) -> UserError:
    return UserError(f"{name!r} expects nothing", item.place, EXAMPLES, "wrong-type")


def _text(item: Item, what: str) -> _Text:
    if not isinstance(item.value, str):  # a boolean is a claim too; what is none is refused there
        return _Text(Claim.from_item(item, what).text, item.place, None)
    return _Text(item.value, item.place, item.text_at).part(0)


def _steps(text: _Text) -> Iterator[_Text]:
    rest: _Text | None = text
    while rest is not None:
        step, rest = rest.split(_COMMA)
        yield step


def _kind(head: _Text) -> str:
    return head.text.partition(" ")[0]


def _of_kind(head: _Text, rest: _Text, steps: list[_Text]) -> Expectation:
    """Return the expectation of a kind and what stands behind its colon.

    Raises:
        UserError: there is none like this.
    """
    kind, text = _kind(head), f"{head.text}: {rest.text}"
    if kind not in KINDS:
        raise head.mistake(f"{kind!r} is no kind of expectation", nearest(kind, KINDS) + "; without one: at the end")
    if kind not in ("within", head.text):
        example = "order: [approach, reach]" if kind == "order" else f"{kind}: P while Q"
        raise head.mistake(
            f"{head.text[len(kind) :].strip()!r} is not expected behind {kind!r}", example, len(kind) + 1
        )
    if kind == "order":
        for step in steps:
            if not step.text:
                raise step.mistake("a step of the order is missing", "order: [approach, reach]")
        if len(steps) < 2:
            raise rest.mistake("an order has at least two steps", "order: [approach, reach]")
        return Order(text, head.place, [Step(*step) for step in steps])
    if kind == "within":
        limit, after = _limit(head)
        return Within(text, head.place, limit, rest.claim, after)
    claim, meanwhile = rest.split(_WHILE)
    return Throughout(text, head.place, claim.claim, kind == "always", meanwhile.claim if meanwhile else None)


def _limit(head: _Text) -> tuple[float, Claim | None]:
    """Return the time of a ``within``, and what it counts from, None for the beginning.

    Raises:
        UserError: it has none.
    """
    within_, after = head.split(_AFTER)
    start = len("within ")
    found = read_quantity(within_.text, start) if len(within_.text) > start else None
    example = "within 20 s: outcome == success, or within 2 s after reach failed: retract runs"
    if found is None:
        raise head.mistake("'within' needs a time", example)
    value, unit, end = found
    if unit not in ("s", "") or not is_finite(value):
        raise head.mistake(f"{within_.text[start:end]!r} is no time", "valid: s, ms, min", start)
    if within_.text[end:].strip():
        raise head.mistake(f"{within_.text[end:].strip()!r} is not expected behind a time", example, end + 1)
    return value, after.claim if after else None
