"""The baseline in C, and one short bench on the real processes. Bounds are generous: the machine may be busy."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from humanoid_bt.bench import ticks
from humanoid_bt.bench.baseline import SAME_LOOP, SLEEP_ALONE, Baseline
from humanoid_bt.bench.busy_cores import load
from humanoid_bt.bench.punctuality import Punctuality
from humanoid_bt.bench.reactions import ESTOPS_PER_REPETITION, Reaction
from humanoid_bt.bench.realtime import OURS, measure_realtime
from humanoid_bt.bench.ticks import RecordedTicks
from humanoid_bt.cli.arguments import parser
from humanoid_bt.link.run_folder import default_root

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux only")


def test_the_baseline_runs_beside_any_compiler(tmp_path: Path) -> None:
    baseline = Baseline.compile(tmp_path)
    if baseline is None:
        pytest.skip("no compiler")
    figures = baseline.run(0.2, None, loaded=False)
    assert figures is not None
    same, sleep = figures
    assert (same.loop, sleep.loop) == (SAME_LOOP, SLEEP_ALONE)
    assert same.cycles == sleep.cycles == 200
    assert 0 <= same.late_p50 <= same.late_p99 <= same.late_p999 <= same.late_max


def test_no_compiler_is_no_baseline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    assert Baseline.compile(tmp_path) is None


def test_a_compiler_that_cannot_is_no_baseline(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\nexit 1\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert Baseline.compile(tmp_path) is None


@pytest.mark.parametrize("duration", ["0", "nan", "inf", "1e9", "soon"])
def test_a_duration_that_makes_no_sense_is_refused(duration: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as exit_:
        parser().parse_args(["bench", "--realtime", "--duration", duration])
    assert exit_.value.code == 2
    assert "0.1 to 3600" in capsys.readouterr().err


def test_load_ends_with_its_context() -> None:
    before = set(descendants(os.getpid()))
    with pytest.raises(KeyboardInterrupt), load():
        burning = set(descendants(os.getpid())) - before
        assert len(burning) == len(os.sched_getaffinity(0))
        raise KeyboardInterrupt
    assert not alive(burning)


@pytest.mark.realtime
@pytest.mark.trials
def test_a_short_bench_measures_everything_and_leaves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ticks, "_TURNS", 1)
    before = folders()
    figures = list(measure_realtime(0.3, 1, lambda _text: None, loads=[False]))
    servo = [figure for figure in figures if isinstance(figure, Punctuality) and figure.loop == OURS]
    assert len(servo) == 1
    assert servo[0].cycles + servo[0].missed > 100
    answers = [figure for figure in figures if isinstance(figure, Reaction)]
    assert [answer.repetitions for answer in answers] == [ESTOPS_PER_REPETITION, 1, 1, 1, 1, 1]
    for answer in answers:
        assert len(answer.delays) == answer.standing == answer.repetitions, answer
        assert 0 < answer.p50 < 3000
    (pair,) = [figure for figure in figures if isinstance(figure, RecordedTicks)]
    assert min(pair.recorded.count, pair.plain.count) > 5
    assert pair.recorded.missing == 0
    assert folders() <= before


@pytest.mark.trials
@pytest.mark.realtime
def test_interrupting_the_bench_ends_what_it_started() -> None:
    before = folders()
    command = [sys.executable, "-m", "humanoid_bt", "bench", "--realtime", "--duration", "0.1"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE) as bench:
        deadline = time.monotonic() + 60
        while len(children := set(descendants(bench.pid))) < 2 and time.monotonic() < deadline:
            time.sleep(0.01)
        bench.send_signal(signal.SIGINT)
        assert bench.wait(30) == 130
    assert len(children) >= 2
    assert not alive(children)
    assert folders() <= before


def folders() -> set[str]:
    root = default_root()
    return {path.name for path in root.iterdir() if path.name != ".lock"} if root.exists() else set()


def alive(processes: set[int]) -> list[int]:
    return [pid for pid in processes if Path(f"/proc/{pid}/exe").is_symlink() and state(pid) != "Z"]


def state(pid: int) -> str:
    return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]


def descendants(pid: int) -> list[int]:
    """Return the processes that a process started."""
    found = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        found += [int(child) for child in (task / "children").read_text().split()]
    return found + [deeper for child in found for deeper in descendants(child)]
