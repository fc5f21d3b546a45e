"""Campaigns: what counts as a change, what goes on after a kill, what is told of a trial."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from humanoid_bt.campaign.compare import compare
from humanoid_bt.campaign.conduct import conduct
from humanoid_bt.campaign.digests import changes
from humanoid_bt.campaign.requirement import Requirement
from humanoid_bt.campaign.result import Cost, Result
from humanoid_bt.campaign.stage_trials import Setup, judged, make, pushes, result_of
from humanoid_bt.campaign.store import Store, read_results
from humanoid_bt.campaign.summary import Summary
from humanoid_bt.campaign.table import Row, Table
from humanoid_bt.campaign.trial import Task, Trial
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.campaign.workers import Done
from humanoid_bt.core.errors import UserError
from humanoid_bt.tree.expressions.expression import Truth
from tests.campaign.conftest import Conduct, plan_of, table_of


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


def test_the_time_is_that_of_the_run_whatever_a_skill_calls_time() -> None:
    results = {number: Result("success", "", time=10.0, values={"time": 99.0}) for number in range(3)}
    said = Summary(Table.of(plan_of("0-2"), results), {})
    unit, spread = said.spreads["time"]
    assert (unit, set(spread.values)) == ("s", {10.0})


def test_a_share_is_refused_on_either_side_of_and() -> None:
    for text in ("success >= 95 and fell == 0", "fell == 0 and success >= 95", "fell == 0 or success >= 95"):
        with pytest.raises(UserError, match="'success' is a share"):
            Requirement(Truth.parse(text), {})
    with pytest.raises(UserError, match=r"did you mean 100 %"):
        Requirement(Truth.parse("success >= 100"), {})


def test_all_of_a_seed_come_together() -> None:
    plan = plan_of("0-2", Factor("set.x", "", (1.0, 2.0)))
    (setting,) = plan.settings
    plan = replace(plan, settings=(setting, setting._replace(scene="random_target")))
    assert [trial.seed for trial in plan.trials] == [0] * 4 + [1] * 4 + [2] * 4


def test_files_that_only_one_side_knows_have_changed() -> None:
    assert changes({"a": "1"}, {"a": "1", "b": "2"}) == ["b"]
    assert changes({"a": "1", "b": "2"}, {"a": "1"}) == ["b"]


def test_what_goes_on_keeps_the_plan_that_it_began_with(campaign: Conduct, tmp_path: Path) -> None:
    campaign(plan_of("0-3", description="as it was", workspace="here"))
    with Store(tmp_path / "out", plan_of("0-3", description="otherwise", workspace="there"), resume=True):
        pass
    assert read_results(tmp_path / "out").plan.description == "as it was"


@pytest.mark.parametrize(
    "left", ["recordings", "workers", "journal.jsonl", "explained.jsonl", ".campaign.json.1a2b3c4d"]
)
def test_what_a_kill_leaves_before_campaign_json_is_no_hindrance(campaign: Conduct, tmp_path: Path, left: str) -> None:
    path = tmp_path / "out" / left
    path.parent.mkdir()
    path.touch() if "." in left else path.mkdir()
    assert campaign(plan_of("0-1")).done == 2


class _Fakes:
    """Runs trials at once; what is recorded goes another way, and has no explanation."""

    def run(self, tasks: Any) -> Any:
        for task in tasks:
            result = Result("failure", "again" if task.recording else "at first", "fetch/reach")
            yield Done(task, result, Cost(2.0, 0.5))

    def close(self) -> None:
        pass


def test_a_recording_that_went_another_way_is_marked_and_not_made_twice(tmp_path: Path) -> None:
    told: list[int] = []
    progress: Any = SimpleNamespace(trial=lambda _: None, explaining=told.append, explained=lambda _: None)
    with Store(tmp_path / "out", plan_of("0-3"), False) as store:
        conduct(store, _Fakes(), 2, progress)
        assert [found.same for found in store.explained.values()] == [False, False]
        assert {found.headline for found in store.explained.values()} == {"again"}
        assert store.share_simulating == 0.25
        conduct(store, _Fakes(), 2, progress)  # as after --resume: nothing is left to be done
        conduct(store, _Fakes(), 3, progress)  # one more is asked for
    assert told == [2, 1]


def _run(**report: Any) -> Any:
    given = {"results": [], "touches": [], "bumps": [], "stops": [], "sim_time": 1.0, **report}
    return SimpleNamespace(
        **{"report": SimpleNamespace(**given), "outcome": "success", "reason": "", "succeeded": True, "fell": False},
        **{"missed": [], "trace": "", "stops": []},
    )


def test_what_a_hand_was_sent_to_is_not_bumped_into() -> None:
    touches = [{"thing": "box", "meant": True}, {"thing": "wall", "meant": False}, {"thing": "wall", "meant": False}]
    assert result_of(_run(touches=touches)).bumped == "wall"


def test_a_number_that_is_none_is_left_out_of_results() -> None:
    told = [{"name": "a", "value": float("nan"), "unit": "m"}, {"name": "b", "value": 1.0, "unit": "m"}]
    assert dict(result_of(_run(results=told)).values) == {"b": 1.0}


def test_a_failure_keeps_its_own_outcome_whatever_else_counts() -> None:
    failed = Result("failure", "too far", fell=True)
    assert judged(failed, _run(), ["fell"]) == failed
    assert judged(replace(failed, outcome="success"), _run(), ["fell"]).outcome == "fell"


def test_the_node_is_the_leaf_that_did_something_last(tmp_path: Path) -> None:
    (tmp_path / "trees").mkdir()
    root = "{sequence: [{wait: {name: first, duration: 0.1 s}}, {wait: {name: second, duration: 9 s}}]}"
    (tmp_path / "trees/blame.yaml").write_text(f"format: 1\nroot: {{emergency_stop: {root}}}\n", encoding="utf-8")
    script = ({"at": 0.2, "estop": "mine"},)
    result = make(Setup(str(tmp_path), script))(Task(Trial(0, "blame", "humanoid", "empty", 0, duration=1, dry=True)))[
        0
    ]
    assert (result.outcome, result.node.rpartition("/")[2]) == ("stopped", "second")


def _planned(folder: Path, **more: Any) -> Any:
    import yaml

    from humanoid_bt.campaign.planning import checked_campaign
    from humanoid_bt.files.workspace import Workspace

    file = folder / "campaigns" / "mine.yaml"
    file.parent.mkdir(exist_ok=True)
    file.write_text(yaml.safe_dump({"format": 1, "name": "mine", "tree": "stand", **more}))
    return checked_campaign(file, Workspace(folder)).plan


def test_a_push_goes_ahead_and_may_come_at_the_last_moment(tmp_path: Path) -> None:
    plan = _planned(tmp_path, pushes=[{"at": 2, "force": 10}], duration=2)
    assert {factor.name: factor.values for factor in plan.factors} == {
        **{"push.1.at": (2.0,), "push.1.force": (10.0,), "push.1.direction": (0.0,), "push.1.duration": (0.1,)}
    }
    (push,) = pushes(plan.trials[0])
    assert push["push"]["force"] == [10.0, 0.0, 0.0]


def test_nothing_is_named_twice_and_no_dry_run_falls(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="none of them twice"):
        _planned(tmp_path, tree=["stand", "stand"])
    for what in ("fell", "bumped"):
        with pytest.raises(UserError, match=f"fail_on '{what}' needs a body"):
            _planned(tmp_path, dry=True, fail_on=[what])
    assert _planned(tmp_path, dry=True, fail_on=["stopped"]).fail_on == ("stopped",)
