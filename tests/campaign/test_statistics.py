"""Intervals and tests, compared with what the textbooks and other programs have."""

from __future__ import annotations

import math
import random

import pytest

from humanoid_bt.campaign.statistics import QUANTILES, Rate, Spread, binomial_p, holm, median_interval, wilson


@pytest.mark.parametrize(
    ("count", "of", "low", "high"),
    [  # of scipy.stats.binomtest(...).proportion_ci(method="wilson")
        (0, 10, 0.0, 0.277532799862889),
        (10, 10, 0.722467200137111, 1.0),
        (95, 100, 0.8882495307680808, 0.9784563208456319),
        (499, 1000, 0.468073488750724, 0.529934164766247),
    ],
)
def test_wilsons_interval(count: int, of: int, low: float, high: float) -> None:
    assert wilson(count, of) == pytest.approx((low, high), abs=1e-9)


def test_an_interval_reaches_the_end_that_all_trials_lie_at() -> None:
    for of in range(1, 100):
        assert wilson(0, of).low == 0.0
        assert wilson(of, of).high == 1.0


def test_an_interval_holds_the_rate_as_often_as_it_says() -> None:
    dice = random.Random(1)
    for rate in (0.5, 0.9, 0.97):
        held = 0
        for _ in range(1000):
            low, high = wilson(sum(dice.random() < rate for _ in range(100)), 100)
            held += low <= rate <= high
        assert 0.92 < held / 1000 < 0.98


def test_nothing_is_known_of_no_trial() -> None:
    assert wilson(0, 0) == (0.0, 1.0)
    assert math.isnan(Rate(0, 0).share)
    assert math.isnan(Spread.of([]).quantile(0.5))


@pytest.mark.parametrize(
    ("one", "other", "p"),
    [(0, 5, 0.0625), (5, 0, 0.0625), (3, 9, 0.14599609375), (10, 10, 1.0), (0, 0, 1.0), (1, 20, 2.09808349609375e-05)],
)
def test_the_exact_test_of_pairs(one: int, other: int, p: float) -> None:
    assert binomial_p(one, other) == pytest.approx(p, rel=1e-12)


def test_many_pairs_are_tested_too() -> None:
    assert 0 < binomial_p(4800, 5200) < 1e-3


def test_several_tests_are_corrected() -> None:
    assert holm({"a": 0.01, "b": 0.04, "c": 0.03}) == pytest.approx({"a": 0.03, "b": 0.06, "c": 0.06})
    assert holm({"a": 0.6, "b": 0.7}) == {"a": 1.0, "b": 1.0}


def test_quantiles_lie_between_values() -> None:
    spread = Spread.of([4.0, 1.0, math.nan, 2.0, 3.0])
    assert [spread.quantile(share) for share in (0.0, 0.5, 1.0)] == [1.0, 2.5, 4.0]
    hundred = Spread.of(range(101))
    told = {"min": 0.0, "p5": 5.0, "median": 50.0, "p95": 95.0, "max": 100.0}
    assert {name: hundred.quantile(share) for name, share in QUANTILES.items()} == told


def test_the_interval_of_a_median_is_that_of_the_order() -> None:
    assert median_interval(list(range(100))) == (39, 60)  # the 40th and the 61st value, as tables of it have
    assert median_interval(list(range(6))) == (0, 5)
    assert median_interval(list(range(5))) == (-math.inf, math.inf)  # five are too few
