"""Campaigns of a whole simulated robot: killed, continued, reproduced, explained."""

from __future__ import annotations

import contextlib
import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.campaign.store import RESULTS, read_results
from humanoid_bt.cli import main

pytestmark = pytest.mark.trials

SLIPPERY = [
    *("campaign", "fetch", "--scene", "random_target", "--scene", "ball_on_stand", "--seeds", "0-3", "--duration", "9"),
    *("--condition", "friction=0.1..1", "--push", "at=1s..3s,force=0..150,direction=-180deg..180deg"),
]


@pytest.fixture(scope="module")
def quiet(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The campaign without anything that disturbs it, by one process."""
    out = tmp_path_factory.mktemp("quiet") / "out"
    assert main([*SLIPPERY, "--recordings", "1", "--out", str(out)]) == 0
    return out


def _disturbed(out: Path, disturb: Callable[[int, Path], None], *more: str) -> int:
    """Run the campaign with two processes; do something to it when three trials are done. Return how it ended."""
    command = [sys.executable, "-m", "humanoid_bt", *SLIPPERY, "-j", "2", "--recordings", "0", "--out", str(out), *more]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    journal = out / "journal.jsonl"
    while process.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") >= 3):
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(0.05)
    disturb(process.pid, out)
    process.communicate()
    return process.returncode


def _children(process: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{process}/task/{process}/children").read_text().split()]


def test_a_worker_that_is_killed_changes_nothing(quiet: Path, tmp_path: Path) -> None:
    assert _disturbed(tmp_path / "out", lambda process, _: os.kill(_children(process)[0], signal.SIGKILL)) == 0
    assert (tmp_path / "out" / RESULTS).read_bytes() == (quiet / RESULTS).read_bytes()
    assert any(",2\n" in line for line in (tmp_path / "out" / "wall_clock.csv").open())


def test_a_command_that_is_killed_is_continued_and_leaves_no_process(quiet: Path, tmp_path: Path) -> None:
    left: list[int] = []

    def kill(process: int, _: Path) -> None:
        left.extend(_children(process))
        os.kill(process, signal.SIGKILL)

    assert _disturbed(tmp_path / "out", kill) == -signal.SIGKILL
    done = len(read_results(tmp_path / "out").rows)
    assert 3 <= done < 8
    assert main([*SLIPPERY, "--recordings", "0", "--out", str(tmp_path / "out"), "--resume"]) == 0
    assert (tmp_path / "out" / RESULTS).read_bytes() == (quiet / RESULTS).read_bytes()
    assert len(left) == 2
    assert not [process for process in left if Path(f"/proc/{process}").exists()]


def test_a_command_that_is_interrupted_keeps_what_is_done(quiet: Path, tmp_path: Path) -> None:
    assert _disturbed(tmp_path / "out", lambda process, _: os.kill(process, signal.SIGINT)) == 130
    table = (tmp_path / "out" / RESULTS).read_text().splitlines()
    assert 3 < len(table) < 9
    assert set(table) <= set((quiet / RESULTS).read_text().splitlines())
    assert "are not done" in (tmp_path / "out" / "report.md").read_text()


def test_a_failure_is_explained_and_reproduced(quiet: Path, capsys: pytest.CaptureFixture[str]) -> None:
    causes = json.loads((quiet / "summary.json").read_text())["causes"]
    assert all(len(cause["explained"]) == 1 for cause in causes)
    assert len(list((quiet / "recordings").iterdir())) == len(causes)
    assert main(["campaign", "rerun", str(quiet), str(causes[0]["trials"][0])]) in (1, 3, 5)
    told = capsys.readouterr().out
    assert "as it was, bit for bit" in told
    assert causes[0]["explained"][0] in told


def test_the_command_that_is_told_runs_the_same(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, report = tmp_path / "out", tmp_path / "report.json"
    line = [
        "campaign",
        "fetch",
        "--scene",
        "random_target",
        "--seeds",
        "7",
        "--set",
        "stop_distance=36cm",
        "--duration",
        "4",
    ]
    assert main([*line, "--out", str(out), "--recordings", "0"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    words = shlex.split(told[told.index("humanoid-bt run") :])[1:]
    assert words[:2] == ["run", "fetch"]
    assert main([*words, "--no-record", "--no-view", "--quiet", "--report", str(report)]) == 5
    assert json.loads(report.read_text())["trace_hash"] == read_results(out).rows[0].result.trace
