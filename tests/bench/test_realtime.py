"""The baseline in C, and one short bench on the real processes. Bounds are generous: the machine may be busy."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from humanoid_bt.bench.baseline import SAME_LOOP, SLEEP_ALONE, Baseline
from humanoid_bt.cli.arguments import parser
from humanoid_bt.link.run_folder import default_root

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="Linux only")

BENCH = [sys.executable, "-m", "humanoid_bt", "bench", "--realtime", "--duration", "1", "--repetitions", "1"]


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


@pytest.mark.realtime
@pytest.mark.slow
def test_a_short_bench_measures_everything_and_leaves_nothing(tmp_path: Path) -> None:
    file = tmp_path / "figures.json"
    before = folders()
    done = subprocess.run([*BENCH, "--json", file], capture_output=True, text=True, timeout=150, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    data = json.loads(file.read_text(encoding="utf-8"))
    servo = [loop for loop in data["loops"] if loop["loop"] == "servo"]
    assert [loop["loaded"] for loop in servo] == [False, True]
    assert all(loop["cycles"] + loop["missed"] > 500 for loop in servo)
    assert len(data["reactions"]) == 12
    for reaction in data["reactions"]:
        assert len(reaction["delays"]) == reaction["repetitions"] == reaction["standing"]
        assert 0 < reaction["p50"] < 3000
    assert folders() <= before


@pytest.mark.realtime
def test_interrupting_the_bench_ends_what_it_started() -> None:
    before = folders()
    with subprocess.Popen([*BENCH, "--duration", "30"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as bench:
        time.sleep(1.0)
        children = descendants(bench.pid)
        bench.send_signal(signal.SIGINT)
        assert bench.wait(30) == 130
    assert children
    assert not [pid for pid in children if Path(f"/proc/{pid}").exists()]
    assert folders() <= before


def folders() -> set[str]:
    root = default_root()
    return {path.name for path in root.iterdir() if path.name != ".lock"} if root.exists() else set()


def descendants(pid: int) -> list[int]:
    """Return the processes that a process started."""
    found = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        found += [int(child) for child in (task / "children").read_text().split()]
    return found + [deeper for child in found for deeper in descendants(child)]
