from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from humanoid_bt.campaign.variation import Factor, Variation
from humanoid_bt.core.errors import Place, UserError
from humanoid_bt.core.items import item_of
from humanoid_bt.core.params import Param

_HERE = Place("mine.yaml", 3, 5)
_LENGTH = Param("reach", float, unit="m", minimum=0)


def _factor(value: Any, spec: Param = _LENGTH) -> Factor:
    return Variation.from_item(item_of(value, _HERE), spec.name).factor(f"set.{spec.name}", spec)


def test_a_list_is_tried_whole() -> None:
    assert _factor(["45 cm", 0.5]).levels == (0.45, 0.5)
    assert _factor(["35 cm", "40cm", "12.3 cm", "300 mm"]).levels == (0.35, 0.4, 0.123, 0.3)


def test_what_is_the_same_in_another_unit_is_tried_once() -> None:
    distance = Param("distance", float, doc="", unit="m")
    found = Variation.from_item(item_of(["1 m", "50 cm", "100 cm", 1], Place("here")), "distance")
    assert found.factor("set.distance", distance).values == (1.0, 0.5)


def test_what_is_drawn_lies_between_its_ends_and_fills_them() -> None:
    factor = _factor("40 cm .. 0.5 m")
    drawn = [factor.value(None, seed) for seed in range(500)]
    assert 0.4 <= min(drawn) < 0.405
    assert 0.495 < max(drawn) <= 0.5
    assert abs(sum(drawn) / 500 - 0.45) < 0.005


def test_what_is_drawn_follows_from_seed_and_name_alone() -> None:
    assert [_factor("0 .. 1").value(None, seed) for seed in (0, 1, 2)] == [0.462597, 0.2554, 0.253439]
    other = Param("look", float)
    assert _factor("0 .. 1", other).value(None, 0) != 0.462597


def test_what_is_drawn_and_rounded_stays_between_its_ends() -> None:
    assert Factor("set.reach", ends=(1 / 3, 1 / 3)).value(None, 0) == 1 / 3
    assert Factor("set.reach", ends=(2 / 3, 2 / 3)).value(None, 0) == 2 / 3


def test_whole_numbers_are_drawn_where_they_are_declared() -> None:
    for ends, numbers in (("1 .. 3", range(1, 4)), ("-3 .. 3", range(-3, 4)), ("-4 .. -2", range(-4, -1))):
        factor = _factor(ends, Param("times", int))
        drawn = Counter(factor.value(None, seed) for seed in range(100 * len(numbers)))
        assert sorted(drawn) == list(numbers)
        assert all(75 < count < 125 for count in drawn.values())


def test_whole_numbers_are_drawn_exactly_however_large_they_are() -> None:
    factor = Factor("set.times", ends=(10**30, 10**30 + 2), whole=True)
    assert {factor.value(None, seed) for seed in range(60)} == {10**30, 10**30 + 1, 10**30 + 2}


def test_what_is_drawn_has_digits_for_what_its_ends_are_apart() -> None:
    factor = Factor("set.reach", ends=(1000.001, 1000.004))
    assert [factor.value(None, seed) for seed in (0, 1)] == [1000.002387792, 1000.001766201]


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ("0.5 m .. 40 cm", "runs from 0.5 down to 0.4"),
        ("40 kg .. 50 kg", "has the unit 'kg'"),
        ("0.4 ..", "cannot be drawn from"),
        ("a .. b", "must be a number"),
        ([], "has no values"),
        ([0.4, "-1 m"], "must be >= 0"),
    ],
)
def test_what_cannot_be_tried_is_told_with_its_place(value: Any, message: str) -> None:
    with pytest.raises(UserError, match=r"mine\.yaml:3:5") as error:
        _factor(value)
    assert message in str(error.value)
