"""What a campaign says when it is done: its rates, its quantities, and its levels."""

from __future__ import annotations

import math

import pytest

from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.summary import Summary, percent
from humanoid_bt.campaign.table import Table
from humanoid_bt.campaign.variation import Factor
from tests.campaign.conftest import DRAWN, GRID, Conduct, plan_of, table_of


def test_the_time_is_that_of_the_run_whatever_a_skill_calls_time() -> None:
    results = {number: Result("success", "", time=10.0, values={"time": 99.0}) for number in range(3)}
    said = Summary(Table.of(plan_of("0-2"), results), {})
    unit, spread = said.spreads["time"]
    assert (unit, set(spread.values)) == ("s", {10.0})


def test_each_value_that_is_tried_is_a_level_of_its_own() -> None:
    said = Summary(table_of(bool, float, "0-1", Factor("set.stop_distance", "m", (0.351, 0.354, 0.4))), {})
    levels = said.levels["set.stop_distance"]
    assert [(level.text, level.success.of) for level in levels] == [("0.351 m", 2), ("0.354 m", 2), ("0.4 m", 2)]


@pytest.mark.parametrize(
    ("share", "text"),
    [
        (1.0, "100 %"),
        (0.9999, "99.99 %"),
        (0.99951, "99.95 %"),
        (0.9985, "99.9 %"),
        (0.5, "50 %"),
        (0.0001, "0.01 %"),
        (0.00049, "0.05 %"),
        (0.0, "0 %"),
        (math.nan, "nan %"),
    ],
)
def test_only_all_is_100_percent_and_only_none_0(share: float, text: str) -> None:
    assert percent(share) == text


def test_success_is_told_for_each_value_of_what_varies(campaign: Conduct) -> None:
    said = campaign(plan_of("0-39", GRID, DRAWN))
    assert list(said.levels) == ["set.stop_distance", "condition.friction"]
    assert [(level.text, level.success.of) for level in said.levels["set.stop_distance"]] == [
        ("0.35 m", 40),
        ("0.4 m", 40),
    ]
    assert [level.success.of for level in said.levels["condition.friction"]] == [20, 20, 20, 20]
    assert [said.table.plan.trials[number].seed for number in said.explained] == [3, 13]  # and not one seed twice
