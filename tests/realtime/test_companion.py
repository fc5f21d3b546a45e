"""A process that may come and go: when it counts as gone, and when it is started again."""

from __future__ import annotations

from typing import cast

import pytest

from humanoid_bt.link.run_folder import RunFolder
from humanoid_bt.realtime import companion
from humanoid_bt.realtime.children import Children
from humanoid_bt.realtime.companion import Companion


class Process:
    """Stands for the process, its place among the others, and the clock."""

    def __init__(self) -> None:
        self.signs, self.started, self.killed, self.now = 0, 0, 0, 100.0
        self.ended = ""

    def start(self, _role: str, _module: str) -> None:
        self.started, self.ended = self.started + 1, ""

    def how_ended(self, _role: str) -> str:
        return self.ended

    def kill(self, _role: str) -> None:
        self.killed, self.ended = self.killed + 1, "killed"

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def process(monkeypatch: pytest.MonkeyPatch) -> Process:
    process = Process()
    monkeypatch.setattr(companion.time, "monotonic", process.monotonic)
    return process


@pytest.fixture
def watched(process: Process) -> Companion:
    folder, children = cast(RunFolder, None), cast(Children, process)
    watched = Companion(folder, children, role="gateway", module="", signs=lambda: process.signs)
    watched.begin()
    return watched


def look(watched: Companion, process: Process, ticks: int, *, lives: bool) -> None:
    for _ in range(ticks):
        process.signs += lives
        process.now += 0.02
        watched.look()


def test_one_that_lives_is_left_alone(watched: Companion, process: Process) -> None:
    look(watched, process, 200, lives=True)
    assert (watched.gone, process.started) == ("", 1)


def test_one_that_ended_is_started_again_after_a_second_at_the_earliest(watched: Companion, process: Process) -> None:
    look(watched, process, 10, lives=True)
    process.ended = "exit code 1"
    look(watched, process, 10, lives=False)
    assert (watched.gone, process.started) == ("its process ended (exit code 1)", 1)
    look(watched, process, 40, lives=False)
    assert (process.started, bool(watched.gone)) == (2, True)  # it has not spoken yet
    look(watched, process, 1, lives=True)
    assert watched.gone == ""


def test_one_that_is_silent_is_killed_and_started_again(watched: Companion, process: Process) -> None:
    look(watched, process, 60, lives=True)
    look(watched, process, 10, lives=False)
    assert (watched.gone, process.killed) == ("", 0)  # 0.2 s
    look(watched, process, 10, lives=False)
    assert (watched.gone, process.killed) == ("it does not answer", 0)  # it may only be slow
    look(watched, process, 90, lives=False)
    assert (watched.gone, process.killed, process.started) == ("it does not answer", 1, 2)


def test_who_did_not_look_for_long_takes_nobody_for_gone(watched: Companion, process: Process) -> None:
    look(watched, process, 10, lives=True)
    process.now += 5.0
    look(watched, process, 3, lives=False)
    assert watched.gone == ""


def test_one_that_never_comes_back_is_started_once_a_second(watched: Companion, process: Process) -> None:
    look(watched, process, 10, lives=True)
    for _ in range(250):
        process.ended = "exit code 2"
        look(watched, process, 1, lives=False)
    assert 4 <= process.started <= 6


def test_one_that_does_not_come_up_again_is_given_another_try(watched: Companion, process: Process) -> None:
    look(watched, process, 60, lives=True)
    process.ended = "exit code 1"
    look(watched, process, 5, lives=False)
    assert process.started == 2
    look(watched, process, 1600, lives=False)  # 32 s
    assert (process.killed, process.started) == (1, 3)
