"""Why trials failed: what is one cause, what is another, and which comes first."""

from __future__ import annotations

from humanoid_bt.campaign.causes import Cause, causes
from humanoid_bt.campaign.result import CRASHED, HUNG, Explained, Result
from humanoid_bt.campaign.table import Table
from tests.campaign.conftest import plan_of


def causes_of(*results: Result, explained: dict[int, Explained] | None = None) -> list[Cause]:
    return causes(Table.of(plan_of(f"0-{len(results) - 1}"), dict(enumerate(results))), explained)


def told(found: list[Cause]) -> list[tuple[str, str, str, list[int]]]:
    return [(cause.outcome, cause.node, cause.reason, [row.trial.number for row in cause.rows]) for cause in found]


def test_numbers_make_no_other_cause_but_outcome_and_node_do() -> None:
    found = causes_of(
        Result("failure", "0.1 m off", "t/reach"),
        Result("success", "done"),
        Result("failure", "-2e-05 m off", "t/reach"),
        Result("failure", "0.1 m off", "t/look"),
        Result("timeout", "0.1 m off", "t/reach"),
        Result("failure", "+7 m off", "t/reach"),
    )
    assert told(found) == [
        ("failure", "t/reach", "… m off", [0, 2, 5]),
        ("failure", "t/look", "0.1 m off", [3]),
        ("timeout", "t/reach", "0.1 m off", [4]),
    ]


def test_the_most_frequent_comes_first_and_keeps_its_words() -> None:
    found = causes_of(*[Result("failure", reason) for reason in ("a", "b 1", "c", "b 1", "c", "b 1")])
    assert told(found) == [("failure", "", "b 1", [1, 3, 5]), ("failure", "", "c", [2, 4]), ("failure", "", "a", [0])]


def test_what_recordings_show_belongs_to_the_cause_of_their_trial() -> None:
    shown = {number: Explained("push", f"pushed {number % 2}", "", "") for number in range(4)}
    first, second = causes_of(*[Result("failure", reason) for reason in ("a", "b", "a", "a")], explained=shown)
    assert (first.headlines, first.kinds) == (["pushed 0", "pushed 1"], ["push"])
    assert second.headlines == ["pushed 1"]


def test_what_hangs_or_crashes_is_not_run_again_to_be_recorded() -> None:
    found = causes_of(*[Result(outcome, "") for outcome in ("failure", HUNG, CRASHED)])
    assert [cause.can_be_recorded for cause in found] == [True, False, False]
