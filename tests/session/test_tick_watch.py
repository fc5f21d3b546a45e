"""Ticks that take too long on the wall clock, which nothing else of a run depends on."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

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
SOURCE = '''
import sys
import time

from humanoid_bt import PerceptName, PerceptSource, param


class Stays(PerceptSource):
    """Stay at it."""

    thing: PerceptName = param("thing", doc="Percept that it never publishes.")
    at: str = param("setup", doc="In which of its methods.")
    patience = 60.0

    def setup(self):
        self._stay("setup")

    def look(self, now):
        self._stay("look")

    def _stay(self, at):
        if self.at == at:
            print("here", file=sys.stderr)
            time.sleep(1000.0)
'''
ROOTS = {"slow": "{sequence: [{slow: {takes: $takes}}]}", "hang": "{timeout: {duration: 1 s, hang: }}"}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with slow skills, and a slow percept source."""
    folder = tmp_path_factory.mktemp("slow")
    (folder / "skills").mkdir()
    (folder / "skills" / "slow.py").write_text(SKILLS, encoding="utf-8")
    (folder / "perception").mkdir()
    (folder / "perception" / "stays.py").write_text(SOURCE, encoding="utf-8")
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
    line = 1 + SKILLS.splitlines().index("        time.sleep(1000.0)")
    where = f"the node 'hang/timeout/hang', at skills/slow.py:{line}:9"
    with begun(place, "hang", "--mode", mode) as (process, said):
        told = said.readline()
        assert told.startswith("a tick lasts for ") and told.endswith(f" s by now: it is in {where}\n")
        process.send_signal(signal.SIGINT)
        assert said.readline() == f"Ctrl-C: waiting for {where}; Ctrl-C again ends the run at once\n"
        process.send_signal(signal.SIGINT)
        assert process.wait(20.0) == 130


@pytest.mark.parametrize(
    ("at", "what"),
    [("setup", "the start of the run and of its percept sources"), ("look", "the percept sources")],
)
def test_a_percept_source_that_holds_up_the_end_is_told(place: Path, at: str, what: str) -> None:
    with begun(place, "slow", "--perception", f"stays: {{at: {at}}}") as (process, said):
        assert said.readline() == "here\n"
        process.send_signal(signal.SIGINT)
        assert said.readline() == f"Ctrl-C: waiting for {what}; Ctrl-C again ends the run at once\n"
        process.send_signal(signal.SIGINT)
        assert process.wait(20.0) == 130


@contextmanager
def begun(place: Path, *arguments: str) -> Iterator[tuple[subprocess.Popen[str], IO[str]]]:
    """Give a run, and what it says on standard error."""
    process = subprocess.Popen(
        [sys.executable, "-m", "humanoid_bt", "run", *arguments, "--no-record", "--no-view"],
        cwd=place,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    try:
        yield process, process.stderr
    finally:
        process.kill()
        process.stderr.close()
