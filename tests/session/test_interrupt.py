"""Ctrl-C in a program that runs a session: no tick is torn, and the robot stands before it is raised."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from humanoid_bt.session.interrupt import WholeTick
from tests.session.helpers import last_time


@pytest.fixture(autouse=True)
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)


@pytest.fixture(autouse=True)
def as_in_a_terminal() -> Iterator[None]:
    """Have Ctrl-C, which what a shell starts in the background ignores."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


def test_ctrl_c_in_a_tick_is_raised_when_the_tick_is_over() -> None:
    done = []
    with pytest.raises(KeyboardInterrupt), WholeTick():
        signal.raise_signal(signal.SIGINT)
        done.append("the rest")
    assert done == ["the rest"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_in_one_of_many_ticks_is_raised_when_that_tick_is_over() -> None:
    done = []
    with pytest.raises(KeyboardInterrupt), WholeTick() as ticks:
        ticks.over()
        signal.raise_signal(signal.SIGINT)
        done.append("the rest")
        ticks.over()
        done.append("another tick")
    assert done == ["the rest"]
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_what_a_tick_raises_is_not_hidden_by_a_ctrl_c() -> None:
    with pytest.raises((ValueError, KeyboardInterrupt)) as caught, WholeTick():
        signal.raise_signal(signal.SIGINT)
        raise ValueError("of the tick")
    assert caught.type is ValueError


def test_a_second_ctrl_c_does_not_wait() -> None:
    with pytest.raises(KeyboardInterrupt), WholeTick():
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        raise AssertionError("it waited")
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_third_ctrl_c_ends_a_program_that_catches_the_second() -> None:
    script = """
import signal
from humanoid_bt.session.interrupt import WholeTick
with WholeTick():
    for number in range(5):
        try:
            signal.raise_signal(signal.SIGINT)
        except BaseException:
            pass
        print(number, flush=True)
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout.split()) == (-signal.SIGINT, ["0", "1"])


def test_programs_that_handle_ctrl_c_are_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    noted: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: noted.append(number))
    try:
        with WholeTick():
            signal.raise_signal(signal.SIGINT)
    finally:
        signal.signal(signal.SIGINT, before)
    assert noted == [signal.SIGINT]


CTRL_C = """
import os, signal
import humanoid_bt as hbt

signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell starts in the background ignores it

class Press(hbt.Listener):
    ticks = 0
    def progress(self, time, running):
        self.ticks += 1
        if self.ticks == 30:
            os.kill(os.getpid(), signal.SIGINT)

session = hbt.Session("walk", record="ctrl-c.rrd", camera=False, listener=Press())
try:
    session.run()
except KeyboardInterrupt:
    report, state = session.report, session.engine.sense()[0]
    print(report.outcome, report.reason, report.sim_time, state.base_settled, report.stops)
for seed in range(3):
    hbt.run("walk", seed=seed, listener=Press())
"""


@pytest.mark.trials
def test_ctrl_c_ends_a_program_with_the_robot_standing(tmp_path: Path, project: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(CTRL_C, encoding="utf-8")
    done = subprocess.run([sys.executable, str(script)], cwd=project, check=False, capture_output=True, text=True)
    assert done.stdout == "interrupted Ctrl-C 0.58 True []\n"
    assert done.returncode in (130, -signal.SIGINT)
    assert last_time(project / "ctrl-c.rrd") > 0.6


def test_ctrl_c_while_the_robot_comes_to_a_stand_waits_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    session = hbt.Session("walk", duration=0.5)
    with pytest.raises(KeyboardInterrupt), session:
        session.run_until(lambda s: bool(s.outcome))
        monkeypatch.setattr(session.engine, "clock", Pressing(session.engine.clock))
    assert session.report.outcome == "unfinished"
    assert session.engine.sense()[0].base_settled


@pytest.mark.trials
def test_ctrl_c_while_the_run_is_closed_costs_neither_the_report_nor_what_else_is_closed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = hbt.Session("walk", duration=0.1, record="closing.rrd", camera=False)
    monkeypatch.setattr(session.engine, "close", lambda: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt), session:
        session.run_until(lambda s: bool(s.outcome))
    assert session.report.outcome == "unfinished"
    assert last_time(Path("closing.rrd")) > 0.09


def test_ctrl_c_before_the_run_is_closed_leaves_it_to_be_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    session = hbt.Session("walk", duration=0.1)
    closed: list[str] = []
    monkeypatch.setattr(session.engine, "close", lambda: closed.append("engine"))
    session.start()
    session.run_until(0.06)
    leave = session._drive.loop.leave
    monkeypatch.setattr(session._drive.loop, "leave", lambda *_: signal.raise_signal(signal.SIGINT))
    with pytest.raises(KeyboardInterrupt):
        session.close()
    monkeypatch.setattr(session._drive.loop, "leave", leave)
    session.close()
    session.close()
    assert (session.report.outcome, closed) == ("unfinished", ["engine"])


class Pressing:
    """A clock at whose third reading somebody presses Ctrl-C."""

    def __init__(self, clock: Any) -> None:
        self._clock, self._asked = clock, 0

    def now(self) -> float:
        self._asked += 1
        if self._asked == 3:
            signal.raise_signal(signal.SIGINT)
        return float(self._clock.now())

    def __getattr__(self, name: str) -> Any:
        return getattr(self._clock, name)
