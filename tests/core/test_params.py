from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pytest

from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import item_of
from humanoid_bt.core.params import PerceptName, param, params_of
from humanoid_bt.core.reading import read
from humanoid_bt.core.units import base_unit
from humanoid_bt.decision.assign import assign
from humanoid_bt.files import document


@dataclass(frozen=True)
class Inner:
    x: float = param(doc="Required.")


@dataclass(frozen=True)
class Example:
    length: float = param(1.0, unit="m", minimum=0, maximum=10, doc="A length.")
    angle: float | None = param(None, unit="rad", above=0, doc="An angle.")
    count: int = param(2, minimum=-1, doc="A count.")
    side: Literal["left", "right"] = param("left", doc="A side.")
    form: Literal[1] = param(1, doc="A version.")
    much: Literal["all", "one"] | int = param("all", minimum=1, doc="How much.")
    target: PerceptName = param("ball", doc="A percept.")
    text: str = param("", doc="Text.")
    flag: bool = param(False, doc="A flag.")
    point: tuple[float, float] = param((0.0, 0.0), unit="m", doc="A point.")
    names: list[str] = param([], doc="Names.")
    gains: dict[str, float] = param({}, doc="Gains.")
    scale: float | list[float] = param(1.0, minimum=0, doc="A scale.")
    inner: Inner = param(Inner(0.0), doc="Inner.")
    anything: Any = param(None, doc="Anything.")


def value(name: str, text: str) -> Any:
    return getattr(read(Example, document.parse(f"{name}: {text}", "f")), name)


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("length", "2", 2.0),
        ("length", "25 cm", 0.25),
        ("length", "1e-3", 0.001),
        ("length", "1e+1 mm", 0.01),
        ("angle", "180 deg", math.pi),
        ("angle", "null", None),
        ("count", "3.0", 3),
        ("side", "right", "right"),
        ("much", "one", "one"),
        ("much", "3", 3),
        ("target", "cup", "cup"),
        ("flag", "true", True),
        ("point", "[1, 20 cm]", (1.0, 0.2)),
        ("names", "[a, b]", ["a", "b"]),
        ("gains", "{a: 1}", {"a": 1.0}),
        ("inner", "{x: 3}", Inner(3.0)),
        ("anything", "[1, {a: b}]", [1, {"a": "b"}]),
    ],
)
def test_conversion(name: str, text: str, expected: Any) -> None:
    result = value(name, text)
    assert result == pytest.approx(expected) if isinstance(expected, float) else result == expected
    assert type(result) is type(expected)


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("length", "x", "'length' must be a number, not text 'x'"),
        ("length", "true", "'length' must be a number, not a boolean True"),
        ("length", "null", "'length' must be a number, not nothing"),
        ("length", "[1]", "'length' must be a number, not a list"),
        ("length", "-1", "'length' must be >= 0 and <= 10, not -1"),
        ("length", ".nan", "'length' must be finite"),
        ("length", "1" + "0" * 400, "'length' must be finite"),
        ("length", "1e999", "'length' must be finite"),
        ("length", "1 s", "'length' has the unit 's'"),
        ("angle", "0", "'angle' must be > 0, not 0"),
        ("count", "1.5", "'count' must be a whole number, not a number 1.5"),
        ("count", ".inf", "'count' must be finite"),
        ("side", "lft", "'side' cannot be 'lft' [wrong-choice]\n    did you mean 'left'?"),
        ("side", "[left]", "'side' cannot be a list"),
        ("form", "'1'", "'form' cannot be '1' [wrong-choice]\n    write 1, without quotes"),
        ("form", "2", "'form' cannot be 2 [wrong-choice]\n    valid: 1"),
        ("much", "al", "'much' must be all | one or whole number, not text 'al'"),
        ("much", "0", "'much' must be >= 1, not 0"),
        ("much", "true", "'much' must be all | one or whole number, not a boolean True"),
        ("scale", "true", "'scale' must be a number or list of numbers, not a boolean True"),
        ("scale", "-1", "'scale' must be >= 0, not -1"),
        ("scale", "[1, .inf]", "'scale' must be finite, not inf"),
        ("scale", "[1, a]", "'scale' must be a number, not text 'a'"),
        ("target", "3", "'target' must be a percept, not a number 3"),
        ("text", "true", "'text' must be text, not a boolean True"),
        ("flag", "1", "'flag' must be true or false, not a number 1"),
        ("point", "[1]", "'point' must have 2 values, not 1"),
        ("point", "1", "'point' must be a list of 2 numbers"),
        ("names", "[1]", "'names' must be text, not a number 1"),
        ("gains", "[1]", "'gains' must be a mapping of number"),
        ("inner", "{}", "the key 'x' of 'inner' is missing"),
        ("inner", "3", "'inner' must be a mapping, not a number"),
        ("lenght", "1", "unknown key 'lenght' of it [unknown-key]\n    did you mean 'length'?"),
    ],
)
def test_mistakes(name: str, text: str, message: str) -> None:
    with pytest.raises(UserError) as caught:
        read(Example, document.parse(f"{name}: {text}", "f"), "it")
    assert message in str(caught.value)
    assert all(problem.place for problem in caught.value.problems)


def test_numbers_of_numpy_are_numbers() -> None:
    written = item_of({"count": np.int64(3), "length": np.float32(0.5), "point": (np.float32(1), 2)}, Place("f"))
    assert read(Example, written) == Example(count=3, length=0.5, point=(1.0, 2.0))
    assert type(read(Example, written).count) is int


def test_the_blanks_in_what_is_no_number_are_read_once() -> None:
    with pytest.raises(UserError, match="'length' must be a number"):
        value("length", f"'a{' ' * 300_000}b'")


def test_every_mistake_is_answered_at_once() -> None:
    with pytest.raises(UserError) as caught:
        read(Example, document.parse("length: x\ncount: y\nflg: 1", "f"))
    assert [problem.place.line for problem in caught.value.problems if problem.place] == [1, 2, 3]


class Base:
    speed: float = param(doc="Required.")


class Derived(Base):
    names: list[str] = param(["a"], doc="Names.")


def test_plain_classes_declare_and_inherit_parameters() -> None:
    assert list(params_of(Derived)) == ["speed", "names"]
    assert params_of(Derived)["speed"].required


def test_assigned_defaults_are_not_shared() -> None:
    first, second = Derived(), Derived()
    assign(first, {"speed": 1.0})
    assign(second, {"speed": 2.0})
    first.names.append("b")
    assert (second.names, first.speed) == (["a"], 1.0)


def test_assign_refuses_what_is_missing_or_not_declared() -> None:
    with pytest.raises(TypeError, match="Derived needs the parameter 'speed'"):
        assign(Derived(), {})
    with pytest.raises(TypeError, match="Derived has no parameter 'sped'"):
        assign(Derived(), {"speed": 1.0, "sped": 2})


def test_base_unit() -> None:
    assert [base_unit(text) for text in ("45 cm", "10 deg/s", "3", "left hand", "3 apples")] == [
        "m", "rad/s", None, None, None,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("unit", "hint"), [("cm", "unit='m', and a value may be written in cm"), ("furlong", "valid: m, s")]
)
def test_a_unit_is_one_of_si(unit: str, hint: str) -> None:
    with pytest.raises(ValueError, match=f"a parameter has no unit '{unit}'; {hint}"):
        param(1.0, unit=unit, doc="How far.")
