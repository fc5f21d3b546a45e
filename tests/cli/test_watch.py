"""``humanoid-bt run --watch``: what a user sees who edits the tree meanwhile."""

from __future__ import annotations

import json
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from io import StringIO
from pathlib import Path
from typing import NamedTuple

import pytest
from rich.console import Console

from humanoid_bt.cli.printer import Printer
from tests.cli.test_process import PROGRAM, environment

PATIENCE = 20.0  # s that anything may take on a busy machine
WALK = "format: 1\nroot:\n  emergency_stop: walk\n"
BROKEN = "format: 1\nroot:\n  emergency_stop: {wak: }\n"


class Watched(NamedTuple):
    process: subprocess.Popen[str]
    tree: Path
    output: Path
    report: Path

    def says(self, text: str) -> None:
        """Wait until it has printed a text."""
        deadline = time.monotonic() + PATIENCE
        while text not in self.output.read_text(encoding="utf-8"):
            assert self.process.poll() is None and time.monotonic() < deadline, self.output.read_text(encoding="utf-8")
            time.sleep(0.01)

    def ends(self) -> tuple[int, list[dict[str, object]]]:
        """End it with Ctrl-C; return its exit code and what it reports of edits."""
        self.process.send_signal(signal.SIGINT)
        code = self.process.wait(PATIENCE)
        return code, json.loads(self.report.read_text(encoding="utf-8"))["reloads"]


@pytest.fixture
def watch(project: Path, tmp_path: Path) -> Iterator[Callable[..., Watched]]:
    """Start a watched run of a tree that walks."""
    runs: list[Watched] = []

    def start(*options: str) -> Watched:
        tree, output, report = project / "trees" / "mine.yaml", tmp_path / "out.txt", tmp_path / "report.json"
        tree.write_text(WALK, encoding="utf-8")
        command = [*PROGRAM, "run", "mine", "--watch", "--report", str(report), *options]
        with output.open("w") as stream:
            process = subprocess.Popen(
                command,
                cwd=project,
                env=environment(PYTHONUNBUFFERED="1"),
                stdin=subprocess.DEVNULL,
                stdout=stream,
                stderr=subprocess.STDOUT,
            )
        runs.append(Watched(process, tree, output, report))
        return runs[-1]

    yield start
    for run in runs:
        if run.process.poll() is None:
            run.process.kill()
        run.process.wait()


@pytest.mark.trials
def test_a_broken_edit_and_its_fix(watch: Callable[..., Watched]) -> None:
    run = watch("--no-record", "--pace", "2")
    run.says("▶ walk")
    run.tree.write_text(BROKEN, encoding="utf-8")
    run.says("■ trees/mine.yaml changed: 1 mistake, the old tree goes on\n            trees/mine.yaml:3:20: error: ")
    run.tree.write_text(WALK.replace("walk", "{wait: {name: pause, duration: 0.2}}"), encoding="utf-8")
    run.says("• trees/mine.yaml changed: reloaded (2 nodes)\n")
    run.says("○ walk halted: replaced by an edited tree\n")
    run.says("▶ pause ")
    run.says("• the tree ended: success; waiting for an edit\n")
    code, reloads = run.ends()
    assert code == 0
    assert [reload["outcome"] for reload in reloads] == ["refused", "reloaded"]
    assert "reloads    1, 1 refused" in run.output.read_text(encoding="utf-8")


@pytest.mark.trials
@pytest.mark.trials
@pytest.mark.realtime
def test_an_edit_in_realtime_mode_moves_the_robot_on(watch: Callable[..., Watched]) -> None:
    run = watch("--mode", "realtime", "--no-record")
    run.says("▶ walk")
    other = run.tree.with_suffix(".tmp")
    other.write_text(WALK.replace("walk", "{walk: {name: stroll}}"), encoding="utf-8")
    other.rename(run.tree)
    run.says("trees/mine.yaml changed: reloaded (2 nodes)\n")
    run.says("▶ stroll walking\n")
    code, reloads = run.ends()
    report = json.loads(run.report.read_text(encoding="utf-8"))
    assert code == 130
    assert [reload["outcome"] for reload in reloads] == ["reloaded"]
    assert not report["fell"]
    walked = [entry["time"] for entry in report["timeline"] if entry["status"] == "RUNNING"]
    assert walked[-1] > reloads[0]["time"]


@pytest.mark.parametrize("columns", [50, 80])
def test_mistakes_stand_below_each_other_at_any_width(columns: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", str(columns))
    out = StringIO()
    printer = Printer(Console(file=out, force_terminal=True, width=columns, no_color=True, highlight=False), quiet=True)
    mistake = "trees/mine.yaml:3:20: error: unknown node 'wak\x1b[2J'\n"
    mistake += "    did you mean 'walk'? valid: approach, idle, reach, walk"
    printer.event(2.5, "error", f"trees/mine.yaml changed: 1 mistake, the old tree goes on\n{mistake}")
    lines = [line for line in out.getvalue().splitlines() if not line.startswith("\x1b[?25")]
    assert lines[0].replace("\x1b[2m", "").startswith("   2.50 s")
    assert [line for line in lines if line.startswith(" " * 12 + "trees/mine.yaml:3:20: error")]
    assert [line for line in lines if line.startswith(" " * 16 + "did you mean")]
    assert "\x1b[2J" not in out.getvalue()
    assert all(len(line) <= columns for line in lines[1:])
