"""Processes that die, hang, and run out of memory: each costs its own trial at most."""

from __future__ import annotations

import math
import os
import subprocess
from collections import deque
from multiprocessing.connection import Pipe
from pathlib import Path

import pytest

from humanoid_bt.campaign.trial import Task, Trial
from humanoid_bt.campaign.workers import Done, Workers, _Worker
from humanoid_bt.core.errors import UserError
from tests.campaign.stand_ins import DIES, DIES_ONCE, HANGS, HOGS, RAISES, REFUSES, make


def _run(begun: Path, *seeds: int, count: int = 2, time_limit: float = 60.0) -> dict[int, Done]:
    workers = Workers(make, (begun,), count=count, time_limit=time_limit, memory=1 << 30, logs=begun)
    done = list(workers.run(_task(number, seed) for number, seed in enumerate(seeds)))
    assert sorted(one.task.trial.number for one in done) == list(range(len(seeds)))
    return {one.task.trial.seed: one for one in done}


def _task(number: int, seed: int) -> Task:
    return Task(Trial(number, "fetch", "humanoid", "empty", seed))


def _times(begun: Path, seed: int) -> int:
    return len((begun / f"begun-{seed}").read_text().splitlines())


def test_a_process_loads_once_for_many_trials(begun: Path) -> None:
    _run(begun, *range(40), count=2)
    processes = {(begun / f"begun-{seed}").read_text() for seed in range(40)}
    assert len(processes) <= 2


def test_a_killed_process_loses_only_its_trial_which_is_run_again(begun: Path) -> None:
    done = _run(begun, 1, DIES_ONCE, 2)
    assert done[DIES_ONCE].result.reason == f"the hand is {DIES_ONCE} cm away"
    assert done[DIES_ONCE].cost.attempts == 2
    assert _times(begun, DIES_ONCE) == 2
    assert [_times(begun, seed) for seed in (1, 2)] == [1, 1]


def test_what_is_run_again_comes_before_what_waits(begun: Path) -> None:
    assert list(_run(begun, DIES_ONCE, 1, 2, count=1)) == [DIES_ONCE, 1, 2]


def test_ctrl_c_is_not_for_the_processes(begun: Path) -> None:
    workers = Workers(make, (begun,), count=1, time_limit=60.0, memory=None, logs=begun)
    workers.run_one(_task(0, 1))
    process = int((begun / "begun-1").read_text())
    assert os.getsid(process) == process
    workers.close()


def test_a_trial_that_kills_its_process_each_time_is_told(begun: Path) -> None:
    result = _run(begun, DIES, 1)[DIES].result
    assert (result.outcome, _times(begun, DIES)) == ("crashed", 3)
    assert "out of memory" in result.reason


def test_memory_is_bounded_where_that_is_asked(begun: Path) -> None:
    result = _run(begun, HOGS)[HOGS].result
    assert (result.outcome, result.reason.rsplit(": ", 1)[-1]) == ("crashed", "MemoryError")


def test_an_exception_of_ours_is_told_with_its_last_words(begun: Path) -> None:
    assert _run(begun, RAISES)[RAISES].result.reason.endswith("exit code 1 each time: ValueError: a bug")


class Process:
    """One that ends so long after it said its last."""

    def __init__(self, after: float, code: int = 1) -> None:
        self.after, self.code, self.ends_with = after, None if after else code, code

    def wait(self, patience: float = math.inf) -> int | None:
        if self.code is None and patience < self.after:
            raise subprocess.TimeoutExpired("worker", patience)
        self.code = self.ends_with if self.code is None else self.code
        return self.code

    def poll(self) -> int | None:
        return self.code

    def kill(self) -> None:
        self.code = -9 if self.code is None else self.code


@pytest.mark.parametrize(
    ("after", "code", "how"),
    [
        (5.0, 1, "its process ended with exit code 1 each time: KeyError: 'oops'"),
        (5.0, -6, "its process ended with signal SIGABRT each time: KeyError: 'oops'"),
        (5.0, -35, "its process ended with signal 35 each time: KeyError: 'oops'"),  # of those without a name
        (1e9, 1, "its process answered no more and did not end each time: KeyError: 'oops'"),
    ],
)
def test_what_is_ended_from_here_was_not_killed_from_outside(begun: Path, after: float, code: int, how: str) -> None:
    log = begun / "worker.log"
    log.write_text("Traceback:\nKeyError: 'oops'\n")
    here, there = Pipe()
    there.close()
    task = Task(Trial(0, "fetch", "humanoid", "empty", 0))
    worker = _Worker("worker-1", Process(after, code), here, task=task, log=log)  # type: ignore[arg-type]  # what is asked of a process
    workers = Workers(make, (begun,), count=1, time_limit=60.0, memory=None, logs=begun)
    workers._workers.append(worker)
    worker.attempts = 3
    (done,) = workers._heard(worker, deque())
    assert done.result.reason == how


def test_a_trial_that_hangs_is_ended(begun: Path) -> None:
    done = _run(begun, HANGS, 1, 2, time_limit=2.0)
    assert done[HANGS].result.outcome == "hung"
    assert "longer than 2 s on the wall clock" in done[HANGS].result.reason
    assert _times(begun, HANGS) == 1


def test_a_mistake_of_the_user_ends_all_with_its_place(begun: Path) -> None:
    with pytest.raises(UserError, match=r"mine.yaml:3:4: error: no such thing\n    valid: others"):
        _run(begun, 1, REFUSES)


def test_who_wants_no_more_leaves_no_process(begun: Path) -> None:
    workers = Workers(make, (begun,), count=2, time_limit=60.0, memory=None, logs=begun)
    trials = workers.run(Task(Trial(number, "fetch", "humanoid", "empty", number)) for number in range(100))
    next(trials)
    trials.close()
    for seen in begun.glob("begun-*"):
        for process in seen.read_text().split():
            assert not Path(f"/proc/{process}").exists()
