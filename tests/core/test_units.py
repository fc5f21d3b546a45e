"""How people read numbers."""

from __future__ import annotations

import math

import pytest

from humanoid_bt.core.units import nonzero, readable, readable_apart, readable_pair, written_quantity


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (0.004, "m", "0.4 cm"),
        (0.0999, "m", "10 cm"),
        (0.5, "m", "0.5 m"),
        (2.0, "m", "2 m"),
        (-1.946, "m", "-1.95 m"),
        (-0.0, "m", "0 cm"),
        (math.pi / 3, "rad", "60 deg"),
        (0.05, "rad", "2.9 deg"),
        (-math.pi, "rad/s", "-180 deg/s"),
        (0, "rad", "0 deg"),
        (1.0000000002, "s", "1 s"),
        (0.02, "s", "0.02 s"),
        (0.411, "", "0.41"),
        (0.0123, "", "0.012"),
        (100.0, "", "100"),
        (1200, "", "1200"),
        (True, "", "true"),
        (None, "", "null"),
        ("left", "", "left"),
        ([1.0, 2.5, "x"], "", "[1, 2.5, x]"),
        (-1e-17, "m", "0 cm"),
        (0.0042, "s", "0.0042 s"),
        (0.001, "rad", "0.1 deg"),
        (math.inf, "s", "inf s"),
    ],
)
def test_values_have_the_units_and_digits_that_help(value: object, unit: str, text: str) -> None:
    assert readable(value, unit) == text


def test_two_that_are_nearly_the_same_can_be_told_apart() -> None:
    assert readable_pair(0.9006, 0.9) == ("0.901", "0.9")
    assert readable_pair(0.5, 0.5, "m") == ("0.5 m", "0.5 m")
    assert readable_pair(math.radians(60.2), math.radians(60), "rad") == ("60.2 deg", "60 deg")
    assert readable_pair("left", "left") == ("left", "left")


@pytest.mark.parametrize(
    ("values", "unit", "texts"),
    [
        ((0.351, 0.354, 0.5, 0.351), "m", ["0.351 m", "0.354 m", "0.5 m", "0.351 m"]),
        ((1000001.0, 1000002.0), "", ["1000001", "1000002"]),
        (([0.351, 1], [0.354, 1]), "", ["[0.351, 1]", "[0.354, 1]"]),
        (("left", "right", 2), "", ["left", "right", "2"]),
    ],
)
def test_all_that_differ_can_be_told_apart(values: tuple[object, ...], unit: str, texts: list[str]) -> None:
    assert readable_apart(values, unit) == texts


def test_the_digits_of_what_is_no_quantity_are_read_once() -> None:
    assert written_quantity("1" * 300_000 + "!") is None


@pytest.mark.parametrize(
    ("value", "shown"), [(118.4, "118"), (1.0, "1"), (0.97, "1"), (0.34, "0.3"), (-0.02, "-0.02"), (-0.0, "0")]
)
def test_a_number_that_is_not_zero_is_not_shown_as_zero(value: float, shown: str) -> None:
    assert nonzero(value) == shown
