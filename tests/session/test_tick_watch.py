"""Ticks that take too long on the wall clock, which nothing else of a run depends on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from humanoid_bt.session.session import Session
from humanoid_bt.session.tick_watch import TickWatch
from tests.session.helpers import Told

SKILLS = '''
import time

from humanoid_bt import Skill, Status, param


class Slow(Skill):
    """Take long in every fifth tick."""

    takes: float = param(0.0, unit="s", doc="How long.")

    def initialise(self) -> None:
        self._ticks = 0

    def update(self) -> Status:
        self._ticks += 1
        if self._ticks % 5 == 0:
            time.sleep(self.takes)
        return self.running("") if self._ticks < 12 else self.succeed("done")


class Hang(Skill):
    """Never return."""

    def update(self) -> Status:
        self._ask()

    def _ask(self) -> None:
        time.sleep(1000.0)
'''
ROOTS = {"slow": "{sequence: [{slow: {takes: $takes}}]}", "hang": "{timeout: {duration: 1 s, hang: }}"}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with slow skills."""
    folder = tmp_path_factory.mktemp("slow")
    (folder / "skills").mkdir()
    (folder / "skills" / "slow.py").write_text(SKILLS, encoding="utf-8")
    (folder / "trees").mkdir()
    parameters = {"slow": "parameters: {takes: 0 s}\n", "hang": ""}
    for name, root in ROOTS.items():
        text = f"format: 1\n{parameters[name]}root: {root}\n"
        (folder / "trees" / f"{name}.yaml").write_text(text, encoding="utf-8")
    return folder


def test_slow_ticks_are_told_once_counted_and_change_nothing(place: Path) -> None:
    reports, told = [], Told()
    for takes in (0.0, 0.15):
        told.events.clear()
        reports.append(Session("slow", workspace=place, listener=told, takes=takes).run())
    quick, slow = reports
    assert quick.slow_ticks == {"count": 0, "worst": None}
    assert slow.slow_ticks["count"] == 2
    worst = slow.slow_ticks["worst"]
    assert worst["node"] == "slow/sequence/slow"
    assert worst["time"] in (0.08, 0.18)
    assert worst["duration"] >= 0.15
    line = 1 + SKILLS.splitlines().index("            time.sleep(self.takes)")
    (warning,) = [text for _, level, text in told.events if level == "warning"]
    assert warning.startswith("a tick took 1")
    assert f"the node 'slow/sequence/slow', at {place / 'skills/slow.py'}:{line}:" in warning
    assert quick.trace_hash == slow.trace_hash


def test_what_a_tick_waits_for_a_processor_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    waited = iter([0.0, 10.0, 20.0, 20.0, 20.0, 20.0])
    times = iter([1.0, 11.015, 30.0, 30.022, 40.0, 40.021])  # the last is not the worst
    ticks = TickWatch()
    monkeypatch.setattr(ticks._processor, "waited", lambda: next(waited))
    monkeypatch.setattr(time, "perf_counter", lambda: next(times))
    for now in (0.4, 0.5, 0.6):
        ticks.begin()
        assert ticks.finish(now) == ""  # nobody saw which node it was
    monkeypatch.undo()
    assert ticks.to_dict() == {"count": 2, "worst": {"time": 0.5, "node": "", "duration": 0.022}}


@pytest.mark.parametrize(
    "mode", ["lockstep", pytest.param("realtime", marks=(pytest.mark.realtime, pytest.mark.trials))]
)
def test_a_skill_that_never_returns_is_named_and_a_second_ctrl_c_ends_it(place: Path, mode: str) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "humanoid_bt", "run", "hang", "--no-record", "--no-view", "--mode", mode],
        cwd=place,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    line = 1 + SKILLS.splitlines().index("        time.sleep(1000.0)")
    where = f"the node 'hang/timeout/hang', at skills/slow.py:{line}:9"
    try:
        told = process.stderr.readline()
        assert told.startswith("a tick lasts for ") and told.endswith(f" s by now: it is in {where}\n")
        process.send_signal(signal.SIGINT)
        assert process.stderr.readline() == f"Ctrl-C: waiting for {where}; Ctrl-C again ends the run at once\n"
        process.send_signal(signal.SIGINT)
        assert process.wait(20.0) == 130
    finally:
        process.kill()
        process.stderr.close()
