"""Breaking tree files at random, each time in the same way for the same seed."""

from __future__ import annotations

import random
import re
from collections.abc import Callable

TOKENS = [
    *("", ":", "- ", "[", "]", "{", "}", "#", "&a ", "*a", "<<: *a", "!!python/name:os", "|", ">-", "?", "%", "@", "`"),
    *("'", '"', "~", "null", "true", "no", "-1", "0", "1e999", ".inf", ".nan", "9" * 400, "0x10", "1_000", "12:30:45"),
    *("3 parsecs", "2024-01-01", "$", "$nothing", "$reach_distance", "--- ", "...", "\t", "\r", "\x85", "\u2028"),
    *(
        "ä",
        "🤖",
        "\ufeff",
        "\u202e",
        "\x00",
        "\x1b[2J",
        "\ud800",
        r'"\uD800"',
        r'"\UFFFFFFFF"',
        "a/b",
        "name",
        "children",
    ),
    *("root", "format", "parameters", "idle", "reach", "parallel", "watchdog", "emergency_stop", "on_stale", "percept"),
    *("# allow no-time-limit: it ends", "# allow syntax", "# allow a, b: c", "# allow", "# allow: x"),
]
"""What is put in the place of a word."""

VALUES = [
    *(
        "1",
        "-1",
        "1.5",
        "1e-9",
        "true",
        "null",
        "text",
        "''",
        "[]",
        "{}",
        "[1, 2]",
        "[[], {}]",
        "{a: 1}",
        "{a: {b: c}}",
    ),
    *("idle", "{idle: }", "[idle, idle]", "{sequence: [idle]}", "{idle: {name: x}, reach: {target: target}}", "$x"),
    *("$target", "${x}", "5 m", "5 kg", "-3 deg", ".inf", ".nan", "9999999999999999999", "0x1F", "!!str 3", "'a\nb'"),
    *(
        "{percept: target, max_age: 1, idle: }",
        "{name: {}}",
        "{name: ''}",
        "{children: idle}",
        "{type: number, unit: m}",
    ),
    *(
        "{default: 3}",
        "{type: text, unit: s}",
        "'two words'",
        "[idle, {reach: {target: 3}}]",
        "&b [*b]",
        "{<<: {a: 1}}",
    ),
]
"""What is put in the place of a value: valid YAML, so that the mistake is found by what reads it."""

_VALUE = re.compile(r"(?<=: )[^\s{}\[\],#][^{}\[\],#\n]*")
_KEY = re.compile(r"[\w.$-]+(?=:(?:\s|$))")
_WORD = re.compile(r"[\w.$-]+|[^\w\s]")


class Mutator:
    """Breaks texts.

    Args:
        seed: of everything random.
    """

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._operators: list[Callable[[str], str]] = [
            *(self.delete_line, self.duplicate_line, self.swap_lines, self.indent_line, self.swap_key_and_value),
            *(self.replace_word, self.replace_word, self.insert_token, self.truncate, self.insert_bytes),
            *[self.replace_value] * 8,
            *[self.replace_key] * 4,
            *(self.nest, self.huge_number, self.alias, self.splice, self.swap_words),
        ]

    def mutate(self, text: str, other: str) -> bytes:
        """Return a text with one to three things broken, perhaps with a part of another."""
        self._other = other
        for _ in range(self._random.choice([1, 1, 1, 2, 2, 3])):
            text = self._random.choice(self._operators)(text)
        data = text.encode("utf-8", "surrogatepass")
        if self._random.random() < 0.03:
            at = self._random.randint(0, len(data))
            data = data[:at] + self._random.randbytes(3) + data[at:]
        return data

    def delete_line(self, text: str) -> str:
        lines = text.splitlines(keepends=True)
        del lines[self._index(lines) : self._index(lines) + 1]
        return "".join(lines)

    def duplicate_line(self, text: str) -> str:
        lines = text.splitlines(keepends=True)
        if lines:
            lines.insert(self._index(lines), self._random.choice(lines))
        return "".join(lines)

    def swap_lines(self, text: str) -> str:
        lines = text.splitlines(keepends=True)
        if lines:
            one, two = self._index(lines), self._index(lines)
            lines[one], lines[two] = lines[two], lines[one]
        return "".join(lines)

    def indent_line(self, text: str) -> str:
        lines = text.splitlines(keepends=True)
        if lines:
            at = self._index(lines)
            lines[at] = self._random.choice(["", " ", "  ", "   ", "\t", " " * 40]) + lines[at].lstrip(" ")
        return "".join(lines)

    def swap_key_and_value(self, text: str) -> str:
        lines = text.splitlines(keepends=True)
        if lines:
            at = self._index(lines)
            lines[at] = re.sub(r"(\S+): *([^\s,}]+)", r"\2: \1", lines[at], count=1)
        return "".join(lines)

    def replace_word(self, text: str) -> str:
        return self._replaced(_WORD, text, TOKENS)

    def replace_value(self, text: str) -> str:
        return self._replaced(_VALUE, text, VALUES)

    def replace_key(self, text: str) -> str:
        return self._replaced(_KEY, text, [*_KEY.findall(text), *_KEY.findall(self._other), "x"])

    def swap_words(self, text: str) -> str:
        words = [match[0] for match in _WORD.finditer(text)]
        if not words:
            return text
        one, two = self._random.choice(words), self._random.choice(words)
        return text.replace(one, two, 1)

    def insert_token(self, text: str) -> str:
        return self._inserted(text, self._random.choice(TOKENS))

    def truncate(self, text: str) -> str:
        return text[: self._random.randint(0, len(text))]

    def insert_bytes(self, text: str) -> str:
        letters = [chr(self._random.choice([self._random.randrange(256), self._random.randrange(0x11000)]))]
        return self._inserted(text, "".join(letters * self._random.randint(1, 3)))

    def nest(self, text: str) -> str:
        depth = self._random.choice([3, 20, 60, 120, 2000])
        shape = self._random.choice(["[", "{a: ", "- ", "{sequence: [", "inverter: {", "? "])
        return self._inserted(text, shape * depth)

    def huge_number(self, text: str) -> str:
        number = self._random.choice(["9" * 400, "1e308", "1e309", "-1e400", "0." + "0" * 400 + "1", "9" * 5000])
        return re.sub(r"\d+(\.\d+)?", number, text, count=self._random.randint(1, 3))

    def alias(self, text: str) -> str:
        text = re.sub(r": ", ": &a ", text, count=self._random.randint(1, 2))
        return self._inserted(text, self._random.choice(["*a", " *a", "<<: *a", "- *a", "{<<: [*a, *a]}"]))

    def splice(self, text: str) -> str:
        begin = self._random.randint(0, len(self._other))
        return self._inserted(text, self._other[begin : begin + self._random.randint(1, 200)])

    def _replaced(self, pattern: re.Pattern[str], text: str, parts: list[str]) -> str:
        places = list(pattern.finditer(text))
        if not places:
            return text
        place = self._random.choice(places)
        return text[: place.start()] + self._random.choice(parts) + text[place.end() :]

    def _inserted(self, text: str, part: str) -> str:
        at = self._random.randint(0, len(text))
        return text[:at] + part + text[at:]

    def _index(self, lines: list[str]) -> int:
        return self._random.randrange(max(len(lines), 1))
