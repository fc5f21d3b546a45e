"""Keys in the terminal of a run, pressed on a terminal that the test holds the other end of."""

from __future__ import annotations

import os
import pty
import re
import select
import signal
import sys
import termios
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from humanoid_bt.cli import main

PATIENCE = 20.0  # s


class Terminal:
    """A program in a terminal of its own."""

    def __init__(self, folder: Path, *arguments: str) -> None:
        command = [sys.executable, "-m", "humanoid_bt", *arguments]
        self._child, self._end = pty.openpty()
        before = termios.tcgetattr(self._end)
        self.before = before
        self.pid = os.fork()
        if self.pid == 0:
            try:
                os.chdir(folder)
                os.close(self._child)
                os.login_tty(self._end)
                os.execv(sys.executable, command)
            finally:
                os._exit(127)
        self.text = ""

    def shows(self, text: str, times: int = 1) -> None:
        """Wait until the program has shown a text so many times."""
        deadline = time.monotonic() + PATIENCE
        while self.text.count(text) < times:
            assert time.monotonic() < deadline, self.text
            ready, _, _ = select.select([self._child], [], [], 0.1)
            if ready:
                seen = os.read(self._child, 4096).decode(errors="replace")
                self.text += re.sub(r"\x1b\[[0-9;?]*[A-Za-z]|\r", "", seen)

    def press(self, key: str) -> None:
        os.write(self._child, key.encode())

    @property
    def settings(self) -> list[object]:
        """How the terminal is set."""
        return termios.tcgetattr(self._end)

    def ends(self) -> int:
        """Wait for the end and return the exit code."""
        deadline = time.monotonic() + PATIENCE
        while not (done := os.waitpid(self.pid, os.WNOHANG))[0]:
            assert time.monotonic() < deadline, self.text
            if select.select([self._child], [], [], 0.1)[0]:
                self.text += os.read(self._child, 4096).decode(errors="replace")
        self.pid = 0
        return os.waitstatus_to_exitcode(done[1])

    def close(self) -> None:
        """End what is left."""
        if self.pid:
            os.kill(self.pid, signal.SIGKILL)
            os.waitpid(self.pid, 0)
        os.close(self._child)
        os.close(self._end)


@pytest.fixture
def start(project: Path) -> Iterator[Callable[..., Terminal]]:
    """Start a program in a terminal of its own."""
    started: list[Terminal] = []

    def start(*arguments: str) -> Terminal:
        started.append(Terminal(project, *arguments))
        return started[-1]

    yield start
    for terminal in started:
        terminal.close()


RUN = ("--no-record", "--no-view", "--duration", "60")


@pytest.mark.trials
@pytest.mark.parametrize("key", [" ", "e"])
def test_a_key_stops_the_robot(key: str, start: Callable[..., Terminal]) -> None:
    terminal = start("run", "walk", *RUN, "--pace", "1", "--on-estop", "end")
    terminal.shows("keys: space or e emergency stop, p pause, q quit")
    terminal.shows("▶ walk")
    assert terminal.settings != terminal.before
    terminal.press("\x1b[A")  # an arrow is none of the keys
    terminal.press(key)
    terminal.shows("emergency stop: a key was pressed (keyboard)")
    assert terminal.ends() == 3
    assert terminal.settings == terminal.before


@pytest.mark.trials
@pytest.mark.realtime
def test_keys_reset_and_quit_in_realtime_mode(project: Path, start: Callable[..., Terminal]) -> None:
    terminal = start("run", "walk", *RUN, "--mode", "realtime")
    terminal.shows("▶ walk")
    terminal.press("e")
    terminal.shows("emergency stop: a key was pressed (keyboard)")
    terminal.press("r")
    terminal.shows("reset by keyboard: done")
    terminal.press("q")
    terminal.shows("interrupted: the key q")
    assert terminal.ends() == 130
    assert terminal.settings == terminal.before


def test_keys_pause_step_and_continue(start: Callable[..., Terminal]) -> None:
    terminal = start("run", "walk", *RUN, "--pace", "1")
    terminal.shows("▶ walk")
    terminal.press("p")
    terminal.shows("paused by keyboard: a key was pressed; c continues, n is one tick")
    terminal.shows("paused at walk: walking; by keyboard: a key was")  # as far as 80 columns go
    assert "reset" not in terminal.text
    terminal.press("n")
    terminal.press("c")
    terminal.shows("continued by keyboard")
    terminal.press("n")
    terminal.shows("paused by keyboard: to go on step by step")
    terminal.press("p")
    terminal.shows("continued by keyboard", times=2)
    terminal.press("q")
    terminal.shows("interrupted: the key q")
    assert terminal.ends() == 130


@pytest.mark.trials
def test_a_run_pauses_at_a_breakpoint(start: Callable[..., Terminal]) -> None:
    terminal = start("run", "walk", *RUN, "--break", "walk")
    terminal.shows("paused by break at walk/emergency_stop/walk: RUNNING: walking; c")
    terminal.press("q")
    assert terminal.ends() == 130


def test_a_breakpoint_needs_somebody_who_continues(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "walk", "--no-record", "--no-view", "--break", "walk"]) == 2
    assert "nobody is at a terminal to continue it" in capsys.readouterr().err


@pytest.mark.parametrize(
    "last",
    [
        pytest.param("\n", id="empty line"),
        pytest.param("\x04", id="Ctrl-D", marks=pytest.mark.trials),
        pytest.param("c\n", id="command", marks=pytest.mark.trials),
        pytest.param("\x1b\n", id="Escape", marks=pytest.mark.trials),
    ],
)
def test_a_line_after_a_line_is_no_row_of_keys(start: Callable[..., Terminal], last: str) -> None:
    terminal = start("run", "walk", *RUN, "--pace", "1")
    terminal.shows("▶ walk")
    terminal.press(":")
    terminal.shows("commands, until an empty line")
    terminal.press("break walk=FAILURE\n")
    terminal.shows("walk=FAILURE")
    terminal.press("erce\n")  # as keys: emergency stop, reset, continue, emergency stop
    terminal.shows("unknown command 'erce'")
    terminal.press(last)
    if last != "c\n":
        terminal.press("c")
    terminal.shows("continued by keyboard")
    terminal.press("q")
    assert terminal.ends() == 130
    assert "emergency stop: a key was pressed" not in terminal.text


@pytest.mark.trials
def test_commands_to_a_paused_run(start: Callable[..., Terminal]) -> None:
    terminal = start("run", "walk", *RUN, "--pace", "1")
    terminal.shows("▶ walk")
    terminal.press(":")
    terminal.shows("paused by keyboard: a key was pressed")
    terminal.press("show\n")
    terminal.shows("▶ walk\n")
    terminal.press(":set walk.raise_after = 5\n:parameters walk\n")
    terminal.shows("set walk/emergency_stop/walk.raise_after = 5")
    terminal.shows("raise_after = 5")
    terminal.press("fly\n")
    terminal.shows("unknown command 'fly'")
    terminal.press("force walk FAILURE\n")
    terminal.press("c\n")
    terminal.shows("✗ walk forced to FAILURE by keyboard")
    assert terminal.ends() == 1
    assert terminal.settings == terminal.before
