"""Ticks after a pause: the tree goes on when control holds the robot no more."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.common import Status

from humanoid_bt.core.messages import Command, Mode, Pause
from humanoid_bt.session.loop import Loop
from humanoid_bt.session.pace import Pace
from humanoid_bt.session.tick_watch import TickWatch


class Control:
    """Holds the robot for a pause, and some ticks longer than it is told to."""

    def __init__(self, late: int) -> None:
        self.late, self.heard, self.time = late, list[str](), 0.0
        self.clock = SimpleNamespace(now=lambda: self.time)

    def submit(self, command: Command) -> None:
        self.heard.append("pause" if command.pause else "go on")

    def advance(self) -> None:
        self.time += 0.02

    def sense(self) -> tuple[Any, Any]:
        held = self.heard and self.heard.count("go on") <= self.late
        return SimpleNamespace(mode=Mode.PAUSED if held else Mode.RUN, time=self.time), {}


class Runner:
    """A tree that runs, and notes in which mode it is ticked, and in which it stands still."""

    status, ended, tree = Status.RUNNING, None, None

    def __init__(self) -> None:
        self.ticked, self.stood = list[Mode](), list[Mode]()
        self.robot = SimpleNamespace(
            clock=SimpleNamespace(stood=0.0),
            repeat=lambda command: command,
            release_all=lambda: Command(0, 0.0),
            stand_still=lambda state, _: self.stood.append(state.mode),
        )

    def tick(self, state: Any, _percepts: object) -> Command:
        self.ticked.append(state.mode)
        return Command(0, state.time)


@pytest.mark.parametrize("late", [0, 3])
def test_a_tree_is_ticked_again_when_control_has_heard_that_the_pause_is_over(late: int) -> None:
    told = dict.fromkeys(("ticked", "happened", "warn_of_percepts"), lambda *_: None)
    teller = SimpleNamespace(trace=SimpleNamespace(tick=lambda *_: None), **told)
    debugger = SimpleNamespace(teller=teller, pause=None, attended=False, ticked=lambda _: None, tell=lambda: None)
    ticks = TickWatch(looks=False)
    control, runner = Control(late), Runner()
    parts: list[Any] = [control, runner, debugger, Pace(None), ticks]
    loop = Loop(*parts)
    loop.stand_still(Pause("program", "to look"))
    for _ in range(2):
        assert loop.tick() is None
    assert control.heard == ["pause", *["go on"] * (late + 1), "go on", "go on"]
    assert runner.stood == [Mode.RUN, *[Mode.PAUSED] * late]
    assert runner.ticked == [Mode.RUN, Mode.RUN]
