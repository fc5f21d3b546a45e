"""The grammar of expressions: from text to a syntax tree. Nothing here is Python, and nothing is evaluated.

    expression  = and { "or" and }
    and         = not { "and" not }
    not         = "not" not | comparison
    comparison  = sum { operator sum [ "hysteresis" sum ] }       operator: < <= > >= == !=
    sum         = product { ("+" | "-") product }
    product     = factor { ("*" | "/") factor }
    factor      = "-" factor | value
    value       = number [unit] | text | "true" | "false" | name [ "." name ] | name "(" [expression {, expression}] ")"
                | "(" expression ")"

A name may have a ``$`` before it, as in the rest of a tree file.

Who asks about a run from outside may also ask what nodes do, ``value = (name | text) verb``, with verbs of its own.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any, ClassVar

from humanoid_bt.core.errors import nearest
from humanoid_bt.core.reading import is_finite
from humanoid_bt.tree.expressions.quantities import read_quantity

MAX_DEPTH = 50
"""Deepest nesting of an expression."""

MAX_LENGTH = 400
"""Most characters of an expression; a longer one is better split over several nodes."""

_TOKEN = re.compile(r"\s*(?:(?P<name>\$?[A-Za-z_]\w*)|(?P<sign><=|>=|==|!=|[<>()+\-*/.,]))")
_SPACE = re.compile(r"\s*")
_TEXT = re.compile(r"'[^']*'|\"[^\"]*\"")
_WORDS = ("and", "or", "not", "true", "false", "hysteresis")
COMPARISONS = ("<", "<=", ">", ">=", "==", "!=")
_FOREIGN = re.compile(r"===|=<|=>|<>|&&?|\|\|?|\*\*|[\^%;]|!(?!=)|=(?!=)")
_MEANT = {"=": "==", "===": "==", "is": "==", "=<": "<=", "=>": ">=", "<>": "!="}
_MEANT |= {"&&": "and", "&": "and", "AND": "and", "||": "or", "|": "or", "OR": "or", "!": "not", "NOT": "not"}
_MEANT |= {"True": "true", "TRUE": "true", "False": "false", "FALSE": "false", "**": "x * x", "^": "x * x"}
"""What other languages say, and how it is said here."""


class SyntaxMistake(Exception):  # noqa: N818 (a mistake of a user, made into a problem by whoever knows the place)
    """Text that is no expression.

    Attributes:
        at: index of the character where that shows.
        hint: what would be valid.
    """

    def __init__(self, message: str, at: int, hint: str = "") -> None:
        super().__init__(message)
        self.at, self.hint = at, hint


@dataclass(frozen=True)
class Literal:
    """A number in SI units with its unit, a text, true or false."""

    value: Any
    unit: str = ""


@dataclass(frozen=True)
class Name:
    """A parameter of the tree or a key of the blackboard."""

    name: str
    at: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Attribute:
    """``of.name``: something about the state or a percept."""

    of: str
    name: str
    at: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Call:
    """A function of values."""

    name: str
    arguments: tuple[Syntax, ...]
    at: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Unary:
    """``not x`` or ``-x``."""

    operator: str
    operand: Syntax
    at: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Binary:
    """``x + y``, ``x and y`` and their like."""

    operator: str
    left: Syntax
    right: Syntax
    at: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Comparison:
    """``x < y``, with a hysteresis if it has one; ``source`` is how its left side is written."""

    operator: str
    left: Syntax
    right: Syntax
    hysteresis: Syntax | None
    source: str
    at: int = field(default=0, compare=False)


@dataclass(frozen=True)
class Doing:
    """``node verb``: whether a node does something; only asked from outside of a tree."""

    node: str
    verb: str
    at: int = field(default=0, compare=False)


Syntax = Literal | Name | Attribute | Call | Unary | Binary | Comparison | Doing


def parse(text: str, verbs: tuple[str, ...] = ()) -> Syntax:
    """Return the syntax tree of an expression.

    Args:
        text: the expression.
        verbs: what can be asked of nodes; nothing in a tree.

    Raises:
        SyntaxMistake: it is none.
    """
    return _Parser(text, verbs).whole()


def names(syntax: Syntax) -> Iterator[str]:
    """Return every name of a parameter or a key in an expression."""
    match syntax:
        case Name(name, _):
            yield name
        case Call(_, arguments, _):
            for argument in arguments:
                yield from names(argument)
        case Unary(_, operand, _):
            yield from names(operand)
        case Binary(_, left, right, _):
            yield from names(left)
            yield from names(right)
        case Comparison(_, left, right, hysteresis, _, _):
            for part in (left, right, hysteresis):
                if part is not None:
                    yield from names(part)


@dataclass(frozen=True)
class _Token:
    kind: str  # name, sign, literal, end
    text: str
    start: int
    value: Any = None
    unit: str = ""


class _Parser:
    _precedence: ClassVar[tuple[tuple[str, ...], ...]] = (("+", "-"), ("*", "/"))

    def __init__(self, text: str, verbs: tuple[str, ...]) -> None:
        self._text, self._verbs = text, verbs
        self._tokens = _tokens(text)
        self._next = 0
        self._depth = 0

    def whole(self) -> Syntax:
        syntax = self._or()
        token = self._token
        if token.kind == "name" and token.text not in _MEANT and self._verbs:
            hint = self._quoted() or nearest(token.text, self._verbs)
            raise SyntaxMistake(f"{token.text!r} is not expected there", token.start, hint)
        if token.kind != "end":
            raise _unexpected(token.text, token.start)
        return syntax

    def _quoted(self) -> str:
        """Return how it is written if words from the last one on are a node's name, "" if nothing is asked of it."""
        begin = end = self._next - 1
        while self._tokens[end].kind == "name" and self._tokens[end].text not in (*_WORDS, *self._verbs):
            end += 1
        if end < self._next or self._tokens[end].text not in (".", *self._verbs):
            return ""
        start, last = self._tokens[begin].start, self._tokens[end - 1]
        stop = last.start + len(last.text)
        written = f"{self._text[:start]}{self._text[start:stop]!r}{self._text[stop:]}"
        return f"a name of several words stands in quotes: {written}"

    @property
    def _token(self) -> _Token:
        return self._tokens[self._next]

    @property
    def _taken_at(self) -> int:
        """Where the token that was taken last begins."""
        return self._tokens[self._next - 1].start

    def _take(self, *texts: str) -> str:
        """Take the next token if it is one of these; return it, else ""."""
        token = self._token
        if token.kind in ("name", "sign") and token.text in texts:
            self._next += 1
            return token.text
        return ""

    def _expect(self, text: str) -> None:
        if not self._take(text):
            hint = f"write {text}" + " to close what ( opens" * (text == ")")
            raise SyntaxMistake(f"{text!r} is expected {self._where()}", self._token.start, hint)

    def _where(self) -> str:
        return "at the end" if self._token.kind == "end" else f"before {self._token.text!r}"

    def _or(self) -> Syntax:
        self._depth += 1
        if self._depth > MAX_DEPTH:
            raise SyntaxMistake(f"it is nested deeper than {MAX_DEPTH} levels", self._token.start)
        left = self._and()
        while self._take("or"):
            at = self._taken_at
            left = Binary("or", left, self._and(), at)
        self._depth -= 1
        return left

    def _and(self) -> Syntax:
        left = self._not()
        while self._take("and"):
            at = self._taken_at
            left = Binary("and", left, self._not(), at)
        return left

    def _not(self) -> Syntax:
        count, at = 0, self._token.start
        while self._take("not"):
            count += 1
        syntax = self._comparison()
        return Unary("not", syntax, at) if count % 2 else syntax

    def _comparison(self) -> Syntax:
        start = self._token.start
        left = self._sum()
        found: Syntax | None = None
        while operator := self._take(*COMPARISONS):
            at = self._taken_at
            source = self._text[start:at].strip()
            start = self._token.start
            right = self._sum()
            hysteresis = self._sum() if self._take("hysteresis") else None
            comparison = Comparison(operator, left, right, hysteresis, source, at)
            found = comparison if found is None else Binary("and", found, comparison, at)
            left = right
        return left if found is None else found

    def _sum(self, level: int = 0) -> Syntax:
        if level == len(self._precedence):
            return self._factor()
        left = self._sum(level + 1)
        while operator := self._take(*self._precedence[level]):
            at = self._taken_at
            left = Binary(operator, left, self._sum(level + 1), at)
        return left

    def _factor(self) -> Syntax:
        count, at = 0, self._token.start
        while self._take("-"):
            count += 1
        value = self._value()
        return Unary("-", value, at) if count % 2 else value

    def _value(self) -> Syntax:
        token = self._token
        if token.kind == "literal":
            self._next += 1
            of = self._of(token.value, token.start) if self._verbs and isinstance(token.value, str) else None
            return of or Literal(token.value, token.unit)
        if self._take("("):
            inner = self._or()
            self._expect(")")
            return inner
        if token.kind == "name" and token.text in ("true", "false"):
            self._next += 1
            return Literal(token.text == "true")
        if token.kind == "name" and token.text in _MEANT:
            raise _unexpected(token.text, token.start)
        if token.kind != "name" or token.text in _WORDS:
            raise SyntaxMistake(f"a value is expected {self._where()}", token.start)
        self._next += 1
        name = token.text.removeprefix("$")
        if self._take("("):
            return Call(name, self._arguments(), token.start)
        return self._of(name, token.start) or Name(name, token.start)

    def _of(self, name: str, at: int) -> Attribute | Doing | None:
        """Return what is asked of a name, None if nothing is."""
        if verb := self._take(*self._verbs):
            return Doing(name, verb, at)
        if not self._take("."):
            return None
        attribute = self._token
        if attribute.kind != "name":
            raise SyntaxMistake(f"a name is expected after '{name}.'", attribute.start)
        self._next += 1
        return Attribute(name, attribute.text, attribute.start)

    def _arguments(self) -> tuple[Syntax, ...]:
        if self._take(")"):
            return ()
        found = [self._or()]
        while self._take(","):
            found.append(self._or())
        self._expect(")")
        return tuple(found)


def _unexpected(text: str, at: int) -> SyntaxMistake:
    hint = f"write {_MEANT[text]}" if text in _MEANT else ""
    return SyntaxMistake(f"{text!r} is not expected there", at, hint)


def _tokens(text: str) -> list[_Token]:
    if len(text) > MAX_LENGTH:
        raise SyntaxMistake(f"it has more than {MAX_LENGTH} characters", MAX_LENGTH)
    found: list[_Token] = []
    at = 0
    while True:
        space = _SPACE.match(text, at)
        at = space.end() if space else at
        if at == len(text):
            found.append(_Token("end", "", at))
            return found
        quantity = read_quantity(text, at)
        if quantity is not None:
            value, unit, end = quantity
            if not is_finite(value):
                raise SyntaxMistake(f"{text[at:end]!r} is not finite", at)
            found.append(_Token("literal", text[at:end], at, value, unit))
        elif match := _TEXT.match(text, at):
            found.append(_Token("literal", match[0], at, match[0][1:-1]))
            end = match.end()
        elif match := _FOREIGN.match(text, at):
            raise _unexpected(match[0], at)
        elif match := _TOKEN.match(text, at):
            found.append(_Token("name" if match["name"] else "sign", match[0].strip(), at))
            end = match.end()
        else:
            raise SyntaxMistake(f"{text[at]!r} means nothing in an expression", at)
        at = end
