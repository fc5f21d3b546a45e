from __future__ import annotations

import math

import pytest

from humanoid_bt.core.units import both_in_words, in_words


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (1.0, "s", "1 s"),
        (0.4123, "", "0.41"),
        (100.0, "N", "100 N"),
        (1.948, "m", "1.95 m"),
        (math.pi / 3, "rad", "60 deg"),
        (-1e-17, "m", "0 m"),
        (0.0042, "s", "0.004 s"),
        (0.001, "rad", "0.06 deg"),
        (math.pi, "rad/s", "180 deg/s"),
        (3, "", "3"),
        (math.inf, "s", "inf s"),
    ],
)
def test_quantities_are_said_as_people_say_them(value: float, unit: str, words: str) -> None:
    assert in_words(value, unit) == words


def test_two_that_are_nearly_the_same_can_be_told_apart() -> None:
    assert both_in_words(0.9006, 0.9, "") == ("0.901", "0.9")
    assert both_in_words(0.5, 0.5, "m") == ("0.5 m", "0.5 m")
    assert both_in_words(math.radians(60.2), math.radians(60), "rad") == ("60.2 deg", "60 deg")
