"""What people most likely meant where a text is no YAML: one slip, its place, and what repairs it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import yaml

_BREAK = re.compile(r"\r\n|[\r\n\x85\u2028\u2029]")
_INDENTATION = re.compile(r"\s*")
_DASHES = re.compile(r"(?:- +)*")
_KEY = re.compile(r"[^\s:#{}\[\],]+:(?=\s|$)")
_NO_BLANK = re.compile(r"(\w+):([^\s:/].*)")
_EQUALS = re.compile(r"(\w+) *= *(.+)")
_OPEN_QUOTE = re.compile(r"(?:^|[:,\[{-]\s+)(['\"])(?:(?!\1).)*$")
_QUOTED = re.compile(r"(?:^|[:,\[{-])\s*((['\"])(?:(?!\2).)*\2\s+)(?=[^\s#])")
_UNUSUAL = {"\t": "a tab", "\u00a0": "a no-break space", "\u3000": "a wide space"}
_CLOSING = {"{": "}", "[": "]"}


@dataclass(frozen=True)
class Slip:
    """What is wrong in a text; line and column count from 1."""

    message: str
    hint: str
    line: int
    column: int


def slip(text: str, error: yaml.MarkedYAMLError) -> Slip:
    """Return what is most likely wrong in a text that YAML refused."""
    page = _Page(text, error)
    for rule in _RULES:
        found = rule(page)
        if found:
            return found
    what = " ".join(part for part in (error.context, error.problem) if part)
    return Slip(f"not valid YAML: {what}", "", page.line + 1, page.column + 1)


@dataclass(frozen=True)
class _Line:
    """One line; indices count from 0."""

    number: int
    raw: str

    @property
    def indent(self) -> int:
        """Where its text begins."""
        return len(self.raw) - len(self.raw.lstrip())

    @property
    def text(self) -> str:
        """What stands in it."""
        return self.raw.strip()

    @property
    def is_item(self) -> bool:
        """Whether it begins a list item."""
        return self.text == "-" or self.text.startswith("- ")

    @property
    def content(self) -> str:
        """What stands behind its dashes."""
        return self.text[_DASHES.match(self.text).end() :]  # type: ignore[union-attr]  # it always matches

    @property
    def content_at(self) -> int:
        """Where that begins."""
        return self.indent + len(self.text) - len(self.content)

    @property
    def key(self) -> str:
        """Its key, else its first word."""
        return self.content.split(":")[0].split(" ")[0] or self.text

    @property
    def has_key(self) -> bool:
        return _KEY.match(self.content) is not None

    @property
    def opens(self) -> bool:
        """Whether what its key holds stands below it."""
        return self.text.endswith(":")

    def slip(self, message: str, hint: str, at: int | None = None) -> Slip:
        """Return a slip in it, at its content if no index is given."""
        return Slip(message, hint, self.number + 1, (self.content_at if at is None else at) + 1)


class _Page:
    """A text, and where YAML refused it."""

    def __init__(self, text: str, error: yaml.MarkedYAMLError) -> None:
        self.lines = [_Line(number, raw) for number, raw in enumerate(_BREAK.split(text))]
        self.problem, self.context = error.problem or "", error.context or ""
        mark = error.problem_mark or error.context_mark
        begin = error.context_mark or mark
        self.line, self.column = (mark.line, mark.column) if mark else (0, 0)
        self.begin = (begin.line, begin.column) if begin else (0, 0)

    @property
    def here(self) -> _Line:
        return self.lines[min(self.line, len(self.lines) - 1)]

    @property
    def beginning(self) -> _Line:
        """The line where what YAML was reading begins."""
        return self.lines[self.begin[0]]

    def above(self, line: _Line) -> Iterator[_Line]:
        """Yield the lines with something in them above one, the nearest first."""
        return (other for other in reversed(self.lines[: line.number]) if _says_something(other))

    def below(self, line: _Line) -> Iterator[_Line]:
        """Yield the lines with something in them below one."""
        return (other for other in self.lines[line.number + 1 :] if _says_something(other))

    def level(self, line: _Line) -> list[_Line]:
        """Return the lines that begin in a line's column, as far as none between them begins before it."""
        found = [line]
        for others in (self.above(line), self.below(line)):
            for other in others:
                if other.indent < line.indent:
                    break
                if other.indent == line.indent:
                    found.append(other)
        return found


def _says_something(line: _Line) -> bool:
    return bool(line.text) and not line.text.startswith("#")


# ---- the slips ------------------------------------------------------------------------------------------------------


def _unusual_blank(page: _Page) -> Slip | None:
    for line in (page.here, *list(page.above(page.here))[:1]):
        blank = _INDENTATION.match(line.raw)
        for at, sign in enumerate(blank[0] if blank else ""):
            if sign != " ":
                what = _UNUSUAL.get(sign, f"U+{ord(sign):04X}")
                return line.slip(f"{what} in the indentation", "indent with blanks, two for each level", at)
    return None


def _quoted_begin(page: _Page) -> Slip | None:
    """A text of which only the beginning stands in quotes: YAML takes that for all of it."""
    for match in _QUOTED.finditer(page.here.raw):
        if match.end() == page.column and "<scalar>" in page.problem:
            rest = page.here.raw[page.column :].split(" #")[0]
            text = match[1] + (re.split(r"[,\]}]", rest)[0] if "flow" in page.context else rest).rstrip()
            other = "'" if match[2] == '"' else '"'
            message = f"text behind the quote {match[2]}, which ends it"
            return page.here.slip(message, f"put all of it in quotes: {other}{text}{other}", page.column)
    return None


def _open_quote(page: _Page) -> Slip | None:
    if "quoted scalar" in page.context:
        quote = page.beginning.raw[page.begin[1]]
        return page.beginning.slip(f"the quote {quote} is not closed", f"end the text with {quote}", page.begin[1])
    if "found '<scalar>'" in page.problem:
        for line in (page.here, *page.above(page.here)):
            if match := _OPEN_QUOTE.search(line.raw):
                return line.slip(f"the quote {match[1]} is not closed", f"end the text with {match[1]}", match.start(1))
    return None


def _brackets(page: _Page) -> Slip | None:
    for sign in "}]":
        if f"found '{sign}'" in page.problem:
            return page.here.slip(f"one {sign} too many", "remove it", page.column)
    if "flow mapping" not in page.context and "flow sequence" not in page.context:
        return None
    first, at = page.beginning, page.begin[1]
    opening = first.raw[at]
    inside = first.raw[at:]
    for line in page.below(first):
        if line.indent <= first.indent:
            break
        inside += line.raw
    if sum(inside.count(sign) for sign in "{[") > sum(inside.count(sign) for sign in "}]"):
        return first.slip(f"the bracket {opening} is not closed", f"end it with {_CLOSING[opening]}", at)
    before = page.here.raw[: page.column]
    if ";" in before[max(before.rfind(","), 0) :]:
        return page.here.slip("';' separates nothing", "write a comma", before.rfind(";"))
    return _between_parts(page)


def _between_parts(page: _Page) -> Slip | None:
    """Return what is wrong between two parts of a list or mapping in brackets."""
    before, rest = page.here.raw[: page.column], page.here.raw[page.column :]
    words = before.split()[-1:] if rest.startswith(":") else rest.split()[:1]
    column = page.here.raw.rfind(words[0], 0, page.column + len(words[0])) if words else -1
    if column < 0:  # YAML counts other columns behind a byte order mark
        return None
    if rest.startswith(":") and before[:column].rstrip().endswith(":"):
        return page.here.slip("a mapping in a mapping needs braces of its own", f"{{{words[0]}: ...}}", column)
    return page.here.slip(f"a comma is missing before {words[0]!r}", f", {words[0]}", column)


def _first_sign(page: _Page) -> Slip | None:
    sign = page.here.raw[page.column : page.column + 1]
    text = page.here.raw[page.column :].split("#")[0].strip()
    if "cannot start any token" in page.problem or "undefined alias" in page.problem:
        return page.here.slip(f"plain text cannot begin with {sign!r}", f"put it in quotes: '{text}'", page.column)
    return None


def _no_colon(line: _Line) -> Slip | None:
    """Return what keeps a line from having a key, None if it has one."""
    text, at = line.content, line.content_at
    if line.has_key:
        return None
    if text.startswith("-"):
        return line.slip("there is no blank after the dash", f"- {text[1:]}")
    if match := _NO_BLANK.fullmatch(text):
        hint = f"{match[1]}: {match[2]}"
        return line.slip(f"there is no blank after the colon of {match[1]!r}", hint, at + match.end(1))
    if match := _EQUALS.fullmatch(text):
        return line.slip(f"{match[1]!r} needs a colon, not '='", f"{match[1]}: {match[2]}", at + text.index("="))
    word, _, rest = text.partition(" ")
    return line.slip(f"there is no colon after {word!r}", f"{word}: {rest}".rstrip(), at + len(word))


def _key_without_colon(page: _Page) -> Slip | None:
    return _no_colon(page.beginning) if "could not find expected ':'" in page.problem else None


def _second_key(page: _Page) -> Slip | None:
    """A key where a value goes on: a second one in its line, or one that is indented too far."""
    if "mapping values are not allowed" not in page.problem:
        return None
    here = page.here
    before = next(page.above(here), here)
    if here.has_key and here.content_at + len(here.key) < page.column:
        value = here.content[len(here.key) + 1 :].strip()
        if value.startswith("("):
            return here.slip("'(' begins no mapping", f"braces do: {here.key}: {{...}}", here.raw.index("("))
        return here.slip("a second colon in one line", f'put the text in quotes: {here.key}: "{value}"', page.column)
    if missing := _no_colon(before):
        return missing
    around = next(page.above(before), None)
    if around is not None and before.content_at < around.content_at == here.content_at:
        message = f"{before.key!r} begins further left than {around.key!r} above and {here.key!r} below"
        return before.slip(message, f"begin it in column {here.content_at + 1}")
    message = f"{here.key!r} begins further right than {before.key!r} above, which has a value already"
    return here.slip(message, f"begin it in column {before.content_at + 1}")


def _dash(page: _Page) -> Slip | None:
    """A dash where none is expected."""
    if "found '-'" not in page.problem and "found '<block sequence start>'" not in page.problem:
        return None
    here, indent = page.here, page.here.indent
    deeper = []
    for line in page.above(here):
        if line.indent <= indent:
            break
        deeper += [line] if line.is_item else []
    if deeper or (page.beginning.is_item and page.begin[1] == indent > page.beginning.indent):
        other = min(deeper, key=lambda line: line.indent) if deeper else page.beginning
        side = "left" if deeper else "right"
        message = f"this dash stands further {side} than the one before {other.key!r} in line {other.number + 1}"
        return here.slip(message, f"begin it in column {other.indent + 1}", indent)
    return _mixed(page.level(here))


def _key_in_list(page: _Page) -> Slip | None:
    """A key where a dash is expected."""
    if "found '?'" not in page.problem:
        return None
    here = page.here
    if here.text.startswith("-"):
        return _no_colon(here) or here.slip("there is no blank after the dash", f"- {here.text[1:]}")
    before = next(page.above(here), here)
    if before.is_item and before.opens and before.indent == here.indent:
        hint = f"begin it in column {before.content_at + 3}, as all that {before.key!r} holds"
        return here.slip(f"{here.key!r} is not indented below {before.key!r}", hint)
    return _mixed(page.level(here))


def _mixed(level: list[_Line]) -> Slip | None:
    """Return what is wrong with lines in one column of which some have a dash and others none."""
    items = [line for line in level if line.is_item]
    keys = [line for line in level if not line.is_item]
    if not items or not keys:
        return None
    if len(items) > len(keys):
        line = min(keys, key=lambda line: line.number)
        if line.text.startswith("-"):
            return line.slip("there is no blank after the dash", f"- {line.text[1:]}")
        return line.slip(f"the dash before {line.key!r} is missing", f"- {line.text}")
    line = items[0]
    return line.slip(f"a dash before {line.key!r}, which is no list item", f"without it: {line.content}", line.indent)


def _odd_column(page: _Page) -> Slip | None:
    if "found '<block mapping start>'" not in page.problem:
        return None
    here = page.here
    columns = {line.content_at: line for line in reversed(list(page.above(here))) if line.has_key}
    if not columns:
        return None
    column = min(columns, key=lambda at: abs(at - here.content_at))
    message = f"{here.key!r} begins in a column where nothing else does"
    return here.slip(message, f"begin it in column {column + 1}, as {columns[column].key!r} above")


_RULES: tuple[Callable[[_Page], Slip | None], ...] = (
    _unusual_blank,
    _quoted_begin,
    _open_quote,
    _brackets,
    _first_sign,
    _key_without_colon,
    _second_key,
    _dash,
    _key_in_list,
    _odd_column,
)
