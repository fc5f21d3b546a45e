from __future__ import annotations

from dataclasses import replace

import pytest

from humanoid_bt.campaign.compare import compare
from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.table import Row, Table
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.campaign.words import verdict
from humanoid_bt.core.errors import UserError
from tests.campaign.conftest import plan_of, table_of


def test_pairs_tell_more_than_rates() -> None:
    found = compare(table_of(lambda seed: seed % 10 > 0), table_of(lambda seed: seed % 20 > 0 or seed == 40))
    assert (found.success.before.count, found.success.after.count) == (90, 96)
    assert [pair[0].trial.seed for pair in found.success.gained] == [10, 30, 40, 50, 70, 90]
    assert found.success.lost == []
    assert found.success.p == pytest.approx(2 / 2**6)
    assert (found.better, found.worse) == (["success"], [])


def test_a_difference_that_chance_makes_is_none() -> None:
    found = compare(table_of(lambda seed: seed > 3), table_of(lambda seed: seed > 6))
    assert len(found.success.lost) == 3
    assert found.success.p == pytest.approx(0.25)
    assert verdict(found) == "nothing differs beyond chance"


def test_a_quantity_is_compared_in_pairs_that_both_succeeded() -> None:
    found = compare(
        table_of(lambda seed: seed != 5, lambda seed: 0.01 + seed / 1e4),
        table_of(bool, lambda seed: 0.012 + seed / 1e4),
    )
    (time, hand) = found.quantities
    assert (time.name, time.p) == ("time", 1.0)
    assert (hand.larger, hand.smaller, hand.unit) == (98, 0, "m")  # 0 and 5 failed on one side
    assert hand.difference == pytest.approx(0.002)
    assert hand.p == 2 * 2 / 2**98, "one of two that are tested"
    assert (found.better, found.worse) == ([], ["hand_error"])


def test_what_varies_is_paired_too() -> None:
    grid = Factor("set.stop_distance", "m", (0.3, 0.4))
    found = compare(table_of(bool, float, "0-9", grid), table_of(bool, float, "5-14", grid))
    assert (found.pairs, found.unpaired, found.by) == (10, (10, 10), ["seed", "set.stop_distance"])


def test_what_is_otherwise_in_all_trials_is_told() -> None:
    found = compare(
        table_of(bool, float, "0-9", Factor("set.stop_distance", "m", (0.3,))),
        table_of(bool, float, "0-9", Factor("set.stop_distance", "m", (0.4,))),
    )
    assert list(found.differs) == [("set.stop_distance", "0.3", "0.4")]


def test_what_varies_in_one_of_them_differs_by_trial_and_not_in_all() -> None:
    one = table_of(bool, float, "0-9", Factor("set.stop_distance", "m", (0.3, 0.4)))
    other = table_of(bool, float, "0-9", Factor("set.stop_distance", "m", (0.4,)))
    assert [list(compare(*tables).differs) for tables in ((one, other), (other, one))] == [[], []]


def test_what_happens_in_trials_and_what_they_fail_on_is_told() -> None:
    results = {number: Result("success", "") for number in range(20)}
    script = ({"at": "2 s", "lose": "target"},)
    plans = plan_of(), plan_of(script=script, fail_on=("bumped", "fell"))
    assert list(compare(*(Table.of(plan, results) for plan in plans)).differs) == [
        ("script", "none", "{at: 2 s, lose: target}"),
        ("fail_on", "none", "bumped, fell"),
    ]


def test_the_cause_that_changed_most_comes_first() -> None:
    def table(*reasons: str) -> Table:
        results = {number: Result("failure", reason) for number, reason in enumerate(reasons)}
        return Table.of(plan_of(f"0-{len(reasons) - 1}"), results)

    found = compare(table(*"aaaab"), table(*"aaabb", "c", "c", "c")).causes
    assert [(cause.text, cause.before, cause.after) for cause in found] == [("c", 0, 3), ("a", 4, 3), ("b", 1, 2)]


def test_what_has_no_partner_is_refused() -> None:
    with pytest.raises(UserError, match="no trials in common"):
        compare(table_of(bool, float, "0-9"), table_of(bool, float, "10-19"))
    with pytest.raises(UserError, match=r"'set\.a' varies in one campaign and is not in the first"):
        compare(table_of(bool, float, "0-9"), table_of(bool, float, "0-9", Factor("set.a", "", (1, 2))))


def test_chance_alone_rarely_makes_a_difference() -> None:
    def random(seed: int, run: int) -> bool:
        return hash((seed, run, 17)) % 5 > 0

    verdicts = [
        verdict(
            compare(
                table_of(lambda seed, run=run: random(seed, run)), table_of(lambda seed, run=run: random(seed, -run))
            )
        )
        for run in range(1, 20)
    ]
    assert sum(text != "nothing differs beyond chance" for text in verdicts) <= 3


def test_a_cause_is_the_same_whatever_its_numbers_and_however_the_trials_ended() -> None:
    def table(*results: Result) -> Table:
        return Table.of(plan_of("0-2"), dict(enumerate(results)))

    def far(outcome: str, distance: float) -> Result:
        return Result(outcome, f"{distance} cm from target", "fetch/reach")

    good = Result("success", "")
    one = table(far("failure", 5.2), far("unfinished", 5.2), good)
    other = table(far("failure", 5.1), far("failure", 4.9), far("failure", 4.9))
    told = [[(cause.text, cause.before, cause.after) for cause in compare(one, to).causes] for to in (other, one)]
    assert told == [[("fetch/reach: … cm from target", 2, 3)], [("fetch/reach: 5.2 cm from target", 2, 2)]]


def test_a_quantity_that_differs_by_chance_is_neither_better_nor_worse() -> None:
    one = table_of(lambda _: True, float, "0-9")
    other = table_of(lambda _: True, lambda seed: seed + (1.0 if seed < 8 else -1.0), "0-9")  # 8 larger, 2 smaller
    (change,) = (change for change in compare(one, other).quantities if change.name == "hand_error")
    assert (change.larger, change.smaller) == (8, 2)
    for found in (compare(one, other), compare(other, one)):
        assert (found.better, found.worse) == ([], [])


def test_who_has_no_partner_is_counted_on_each_side() -> None:
    few, many = table_of(lambda _: True, float, "0-3"), table_of(lambda _: True, float, "2-9")
    assert compare(few, many).unpaired == (2, 6)
    assert compare(many, few).unpaired == (6, 2)


def test_what_is_true_or_false_is_no_quantity() -> None:
    def told(value: bool) -> Table:
        table = table_of(lambda _: True, float, "0-9")
        rows = (Row(row.trial, replace(row.result, values={"held": value})) for row in table.rows)
        return Table(table.plan, tuple(rows))

    assert [change.name for change in compare(told(False), told(True)).quantities] == ["time"]
