"""Pushes and events that a trial ends before: told, and kept apart from those that happened."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from humanoid_bt.campaign.requirement import Requirement
from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.summary import Summary
from humanoid_bt.campaign.table import Row, Table
from humanoid_bt.campaign.trial import Task, Trial
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.campaign.words import figures
from humanoid_bt.tree.expressions.expression import Truth
from tests.campaign.conftest import plan_of

PUSH = {"push.1.at": 0.02, "push.1.force": 1.0, "push.1.direction": 0.0, "push.1.duration": 0.1}
LATE = {name.replace("1", "2", 1): value for name, value in {**PUSH, "push.1.at": 20.0}.items()}


def test_a_trial_says_what_did_not_happen_in_it(tmp_path: Path) -> None:
    (tmp_path / "trees").mkdir()
    (tmp_path / "trees/short.yaml").write_text("format: 1\nroot: {wait: 0.1 s}\n", encoding="utf-8")
    script = ({"at": 9.0, "estop": {}}, {"at": 9.0, "estop": {}, "optional": True}, {"at": 0.02, "estop": {}})
    trial = Trial(0, "short", "humanoid", "empty", 0, {**PUSH, **LATE})
    result = make(Setup(str(tmp_path), script))(Task(trial))[0]
    assert result.missed == "event 1 of the script, push 2"
    assert not result.has_missed("push 1")


@pytest.fixture
def said() -> Summary:
    """A campaign of eight trials, in six of which the first of two pushes never happened, in all the second."""
    factors = (Factor("push.1.force", "N", ends=(10.0, 90.0)), Factor("push.2.force", "N", (5.0, 6.0)))
    plan = plan_of("0-3", *factors)
    missed = {number: "push 1, push 2" if number < 6 else "push 2" for number in range(8)}
    return Summary(Table.of(plan, {number: Result("success", "", missed=what) for number, what in missed.items()}), {})


def test_a_report_says_in_how_many_trials(said: Summary) -> None:
    told = "in 8 of 8 trials push 2 never happened; in 6 of 8 trials push 1 never happened"
    assert dict(figures(said))["missed"] == told
    assert said.to_dict()["missed"] == {"push 2": 8, "push 1": 6}
    assert [said.table.cells(row)["missed"] for row in said.table.rows][5:7] == ["push 1, push 2", "push 2"]
    assert b",missed," in said.table.csv()
    verdict = Requirement(Truth.parse("missed == 0"), {}).judge(said)
    assert (verdict.met, verdict.why) == (False, "missed is 8")


def test_a_table_by_a_push_has_only_trials_in_which_it_happened(said: Summary) -> None:
    assert list(said.levels) == ["push.1.force"]
    assert sum(level.success.of for level in said.levels["push.1.force"]) == 2


def test_where_everything_happened_nothing_is_told(said: Summary) -> None:
    rows = tuple(Row(row.trial, replace(row.result, missed="")) for row in said.table.rows)
    whole = Summary(Table(said.table.plan, rows), {})
    assert "missed" not in dict(figures(whole))
    assert sum(level.success.of for level in whole.levels["push.2.force"]) == 8
