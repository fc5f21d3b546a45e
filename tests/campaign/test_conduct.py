"""Campaigns from their plan to their tables: the same for any number of processes, and after whatever kills them."""

from __future__ import annotations

import io
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pyarrow.parquet as pq
import pytest

from humanoid_bt.campaign.conduct import Progress, conduct, trial_of
from humanoid_bt.campaign.result import Cost, Result
from humanoid_bt.campaign.store import RESULTS, Store, read_results
from humanoid_bt.campaign.table import Table
from humanoid_bt.campaign.variation import Factor
from humanoid_bt.campaign.workers import Done
from humanoid_bt.core.errors import UserError
from tests.campaign.conftest import DRAWN, GRID, Conduct, plan_of
from tests.campaign.stand_ins import DIES_ONCE

ROOT = Path(__file__).parents[2]


def test_the_table_has_what_was_tried_and_what_came_of_it(campaign: Conduct, tmp_path: Path) -> None:
    campaign(plan_of("2-3", GRID, DRAWN))
    head, *rows = (tmp_path / "out" / RESULTS).read_text().splitlines()
    assert head.split(",")[:8] == [
        "trial",
        "id",
        "tree",
        "robot",
        "scene",
        "seed",
        "set.stop_distance",
        "condition.friction",
    ]
    assert head.split(",")[8:] == [
        "outcome",
        "reason",
        "node",
        "time",
        "fell",
        "bumped",
        "stops",
        "missed",
        "result.hand_error",
        "trace",
    ]
    assert rows[2].split(",")[8:12] == ["failure", "the hand is 3 cm away", "fetch/reach", "1.03"]
    table = pq.read_table(tmp_path / "out" / "results.parquet")
    assert table.num_rows == 4
    assert table.schema.field("result.hand_error").metadata == {b"unit": b"m"}
    assert table.column("result.hand_error").to_pylist() == [0.002, 0.002, 0.003, 0.003]


@pytest.mark.parametrize("largest", [2**63 - 1, 2**63, 10**20])
def test_the_table_holds_whole_numbers_of_any_size(largest: int) -> None:
    results = {number: Result("success", "", values={"told": value}) for number, value in enumerate((-5, largest))}
    table = pq.read_table(io.BytesIO(Table.of(plan_of("0-1", Factor("set.n", "", (largest,))), results).parquet()))
    assert list(map(int, table.column("result.told").to_pylist())) == [-5, largest]
    assert list(map(int, table.column("set.n").to_pylist())) == [largest, largest]


def test_the_table_is_the_same_for_any_number_of_processes_and_when_one_is_killed(
    campaign: Conduct, tmp_path: Path, begun: Path
) -> None:
    plan = plan_of(f"{DIES_ONCE}, 0-40", DRAWN)
    campaign(plan, "out-3", count=3)
    assert len((begun / f"begun-{DIES_ONCE}").read_text().splitlines()) == 2 + 1  # and once to be explained
    campaign(plan, "out-1")
    for name in (RESULTS, "results.parquet"):
        assert (tmp_path / "out-1" / name).read_bytes() == (tmp_path / "out-3" / name).read_bytes()


_KILLED = """
import os, signal, sys
from pathlib import Path
from humanoid_bt.campaign.conduct import Progress, conduct
from humanoid_bt.campaign.store import Store
from humanoid_bt.campaign.workers import Workers
from tests.campaign.conftest import plan_of
from tests.campaign.stand_ins import make

class Kill(Progress):
    count = 0
    def trial(self, done):
        self.count += 1
        if self.count == 12:
            os.kill(os.getpid(), signal.SIGKILL)

out, begun = map(Path, sys.argv[1:])
with Store(out, plan_of("0-29"), False) as store:
    conduct(store, Workers(make, (begun,), count=2, time_limit=1.0, memory=None, logs=store.logs), 2, Kill())
"""


def test_a_killed_command_is_continued(campaign: Conduct, tmp_path: Path, begun: Path) -> None:
    killed = [sys.executable, "-c", _KILLED, str(tmp_path / "killed"), str(begun)]
    assert subprocess.run(killed, cwd=ROOT, check=False).returncode == -9
    assert len(read_results(tmp_path / "killed").rows) == 12
    campaign(plan_of("0-29"), "killed", resume=True)
    campaign(plan_of("0-29"), "quiet")
    assert (tmp_path / "killed" / RESULTS).read_bytes() == (tmp_path / "quiet" / RESULTS).read_bytes()


def test_what_is_done_is_not_done_again(campaign: Conduct, begun: Path) -> None:
    class Stop(Progress):
        def trial(self, done: Done) -> None:
            if done.task.trial.number == 12:
                raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        campaign(plan_of("0-20"), progress=Stop())
    campaign(plan_of("0-20"), resume=True)
    times = {seed: len((begun / f"begun-{seed}").read_text().splitlines()) for seed in range(21)}
    assert {seed for seed, often in times.items() if often != 1} <= {3, 13}  # failures, which are explained too


def test_failures_are_grouped_and_some_of_each_explained(campaign: Conduct) -> None:
    said = campaign(plan_of("0-49"))
    (cause,) = said.causes
    assert (cause.outcome, cause.node, cause.reason) == ("failure", "fetch/reach", "the hand is … cm away")
    assert [row.trial.seed for row in cause.rows] == [3, 13, 23, 33, 43]
    assert cause.headlines == ["reach failed: the hand is 3 cm away", "reach failed: the hand is 13 cm away"]
    assert (said.success.count, said.success.of) == (45, 50)
    assert all(found.same for found in cause.explained.values())


def test_a_trial_is_found_by_number_and_by_id(campaign: Conduct, tmp_path: Path) -> None:
    table = campaign(plan_of("0-3")).table
    assert trial_of(table, "2") == trial_of(table, table.rows[2].trial.id)
    with pytest.raises(UserError, match="no trial '9'"):
        trial_of(table, "9")
    assert read_results(tmp_path / "out") == table


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
