"""Text from elsewhere: what a terminal finds in it, and how much of it is kept."""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
from typing import Any

import pytest

from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.texts import one_line, printable, shortened, told

EVERYTHING = "".join(map(chr, range(0x110000)))


def test_no_command_is_left_and_all_else_is() -> None:
    commands = {letter for letter in EVERYTHING if unicodedata.category(letter) in ("Cc", "Cs", "Zl", "Zp")}
    order = {
        letter for letter in EVERYTHING if unicodedata.bidirectional(letter) in ("LRE", "RLE", "LRO", "RLO", "PDF")
    }
    order |= {letter for letter in EVERYTHING if unicodedata.bidirectional(letter) in ("LRI", "RLI", "FSI", "PDI")}
    shown = set(printable(EVERYTHING))
    assert shown & (commands | order) == {"\n", "\t"}
    letters = {letter for letter in EVERYTHING if unicodedata.category(letter)[0] in "LMNPS"} | {" ", "\xa0", "\u3000"}
    assert letters <= shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b]0;mine\x07", r"\x1b]0;mine\x07"),
        ("\x9b31m red", r"\x9b31m red"),
        ("50 %\r100 %\b", r"50 %\r100 %\x08"),
        ("a\u202eb", r"a\u202eb"),
        ("name\udcff", r"name\udcff"),
        ("größer, 大きい 👍", "größer, 大きい 👍"),
    ],
)
def test_commands_are_written_out(text: str, shown: str) -> None:
    assert printable(text) == shown
    assert printable(shown) == shown


def test_one_line_is_one_line() -> None:
    assert one_line("done\n   0.00 s • faked\x0b\u2028") == "done    0.00 s • faked  "


def test_what_is_long_is_cut_and_that_is_told() -> None:
    assert shortened("as it is") == "as it is"
    assert shortened(None) == "None"
    assert shortened("x" * 10_000_000, 30) == "xxxxx… (10,000,000 characters)"
    assert shortened(shortened("x" * 10_000_000, 30), 30) == "xxxxx… (10,000,000 characters)"


def test_an_error_shows_commands_and_keeps_them_as_data() -> None:
    problem = Problem("no \x1b[2J", Place("a\x1b.yaml", 1, 2))
    assert str(problem) == r"a\x1b.yaml:1:2: error: no \x1b[2J"
    assert problem.message == "no \x1b[2J"


def test_an_exception_is_told_whatever_making_its_text_does() -> None:
    class UnspeakableError(Exception):
        def __str__(self) -> str:
            raise RuntimeError("no")

    assert told(ValueError("too far")) == "ValueError: too far"
    assert told(UnspeakableError()) == "UnspeakableError: (its text cannot be made: RuntimeError)"


class _Arm:
    length = 0.6

    def stretch(self) -> None:
        raise AssertionError(length)  # type: ignore[name-defined]  # noqa: F821 (the slip that is told)

    def turn(self, angle: float) -> None:
        raise AssertionError(anglle)  # type: ignore[name-defined]  # noqa: F821 (the slip that is told)


class _Odd:
    def __dir__(self) -> list[Any]:
        return [1, 2]


class _Silent:
    def __dir__(self) -> list[str]:
        raise RuntimeError("no")


@pytest.mark.parametrize(
    ("slip", "meant"),
    [
        (lambda: _Arm().lenght, "; did you mean 'length'?"),
        (lambda: _Arm().weight, ""),
        (lambda: _Arm().stretch(), "; did you mean 'self.length'?"),
        (lambda: _Arm().turn(0.1), "; did you mean 'angle'?"),
        (lambda: _Silent().lenght, ""),
        (lambda: _Odd().lenght, ""),
    ],
)
def test_an_exception_of_a_name_that_is_not_there_is_told_with_what_was_meant(
    slip: Callable[[], object], meant: str
) -> None:
    with pytest.raises((AttributeError, NameError)) as caught:
        slip()
    assert told(caught.value) == f"{caught.typename}: {caught.value}{meant}"
