"""Chaos itself: what it does follows from its seed, and what is not as promised is noticed."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.cycle_log import MODES
from humanoid_bt.core.messages import Mode
from tests.realtime import helpers
from tests.realtime.helpers import environment, until
from tests.safety import chaos, promises
from tests.safety.apart import keep_apart
from tests.safety.chaos import main, summary
from tests.safety.plans import planned
from tests.safety.processes import MARK, Life, marked
from tests.safety.strikes import ENDINGS, FAULTS, Ending
from tests.safety.trial import Trial, tried
from tests.safety.victim import REPOSITORY, Victim

pytestmark = pytest.mark.skipif(not Path("/dev/shm").is_dir(), reason="it needs Linux")


def test_what_is_done_follows_from_the_seed_and_is_everything_in_time() -> None:
    plans = [planned(3, number) for number in range(300)]
    assert plans == [planned(3, number) for number in range(300)]
    assert plans != [planned(4, number) for number in range(300)]
    assert plans[0].strength(0).random() == planned(3, 0).strength(0).random()
    assert {fault.name for plan in plans for _, fault in plan.faults} == {fault.name for fault in FAULTS}
    assert {plan.ending[1].name for plan in plans} == {ending.name for ending in ENDINGS}


def test_what_is_gone_is_not_struck_again() -> None:
    for plan in (planned(5, number, camera=number % 2 == 0) for number in range(300)):
        gone = set() if plan.camera else {"camera"}
        for _, fault in plan.faults:
            assert not gone.intersection(fault.roles), plan
            gone.update(fault.ends)


def test_no_run_is_begun_that_would_not_end_in_time(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    now = [1000.0]

    def takes_25_s(*_: object) -> str:
        now[0] += 25.0
        return "trial"

    monkeypatch.setattr(chaos, "time", SimpleNamespace(monotonic=lambda: now[0]))
    monkeypatch.setattr(chaos, "_renders", lambda _: False)
    monkeypatch.setattr(chaos, "bystander", lambda *_: nullcontext("bystander"))
    monkeypatch.setattr(chaos, "tried", takes_25_s)
    for minutes, trials in ((0.1, 1), (1.0, 2), (1.3, 3)):
        until_ = now[0] + 60 * minutes
        assert list(chaos.soak(0, range(99), tmp_path, tmp_path, until_)) == [*["trial"] * trials, "bystander"]


def test_it_lists_what_it_would_do(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--seed", "3", "--list", "2"]) == 0
    assert capsys.readouterr().out.splitlines() == [str(planned(3, 0)), str(planned(3, 1))]


def test_a_marked_process_is_found_when_its_parent_is_gone() -> None:
    shell = ["sh", "-c", f"{sys.executable} -c 'import time; time.sleep(60)' > /dev/null & echo $!"]
    done = subprocess.run(shell, env=os.environ | {MARK: "lost"}, stdout=subprocess.PIPE, text=True, check=True)
    pid = int(done.stdout)
    try:
        (found,) = marked("lost")
        assert found.pid == pid
        assert not list(marked("los"))
    finally:
        os.kill(pid, 9)
    until("it is gone", lambda: not list(marked("lost")))


@pytest.mark.parametrize(
    ("late", "stall", "problem"), [(0, None, ""), (2, None, "102 ms"), (50, 1050, ""), (50, 1040, "110 ms")]
)
def test_a_stop_that_comes_late_is_noticed(late: int, stall: int | None, problem: str) -> None:
    """Decision is heard last in cycle 1000; control may stall in another one."""
    cycle = np.arange(900, 1300)
    mode = np.where(cycle < 1100 + late, MODES.index(Mode.RUN), MODES.index(Mode.PROTECTIVE_STOP))
    command = np.minimum(cycle // 20, 50)
    rows = SimpleNamespace(columns={"servo": np.stack([cycle, mode, command], axis=1).astype(float)})
    noted = [{"time": (1100 + late) / 1000, "text": "protective_stop: decision silent for more than 100 ms"}]
    if stall is not None:
        noted.append({"time": stall / 1000, "text": "control stalled for 20 ms"})
    victim: Any = SimpleNamespace(log=noted)
    log: Any = SimpleNamespace(cycles=lambda: rows)
    if problem:
        with pytest.raises(AssertionError, match=f"a stop after {problem}"):
            promises.silence_in_time(victim, log)
    else:
        assert promises.silence_in_time(victim, log) == 1


def test_memory_that_grows_is_noticed() -> None:
    lives = {7: Life("control", 600.0, 200 << 20, 210 << 20, 210 << 20)}
    promises.memory_bounded(lives)
    lives[8] = Life("decision", 600.0, 60 << 20, 120 << 20, 60 << 20)
    with pytest.raises(AssertionError, match=r"decision \(8\) grew by 60 MB in 600 s"):
        promises.memory_bounded(lives)


def test_a_failure_comes_with_what_repeats_it() -> None:
    plan = planned(3, 7)
    trial = Trial(plan, Path("somewhere/0007"), [(plan.ending[1].name, 1.25)], "the robot fell")
    told = summary(3, [trial])
    assert "1 runs, 1 faults, 1 failures" in told
    assert f"| {plan.ending[1].name} | 0 of 1 |" in told
    for part in (str(plan), "the robot fell", "at 1.25 s: ", "somewhere/0007", "--seed 3 --trial 7"):
        assert part in told


# ---- on the wall clock ----------------------------------------------------------------------------------------------


@pytest.fixture
def links(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Iterator[Path]:
    """A folder for links in which no other run is."""
    from humanoid_bt.link import run_folder

    monkeypatch.setattr(run_folder, "default_root", run_folder.default_root)  # it is there again afterwards
    keep_apart(tmp_path / "links")
    yield tmp_path / "links"


def leaves_a_process(victim: Victim, _: np.random.Generator) -> None:
    line = [sys.executable, "-c", "import time; time.sleep(60)", "humanoid_bt.record.recorder_process"]
    subprocess.Popen(line, env=os.environ | {MARK: victim.mark})
    victim.process.terminate()


@pytest.mark.trials
@pytest.mark.realtime
def test_what_is_left_behind_is_noticed_and_ended(links: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = replace(planned(0, 0, camera=False), tree="stand", load="no", faults=())
    monkeypatch.setattr(helpers, "PATIENCE", 10.0)
    trial = tried(replace(plan, ending=(0.0, Ending("SIGTERM", leaves_a_process, (130,)))), tmp_path, links)
    assert "nothing is left, not even ['the process" in trial.problem
    assert "(recorder)" in trial.problem


@pytest.mark.trials
@pytest.mark.realtime
def test_a_run_is_struck_and_nothing_is_left(tmp_path: Path) -> None:
    """As from a terminal: perception is stopped for a while, then comes an e-stop, then Ctrl-C."""
    before = set(Path("/dev/shm").glob("humanoid-bt-chaos-*"))
    line = [sys.executable, "-m", "tests.safety.chaos", "--seed", "2", "--trial", "15", "--out", tmp_path]
    done = subprocess.run(line, cwd=REPOSITORY, env=environment(), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 runs, " in done.stdout and "0 failures" in done.stdout
    assert "| control | " in done.stdout
    assert set(Path("/dev/shm").glob("humanoid-bt-chaos-*")) <= before
    assert not list(tmp_path.iterdir())
