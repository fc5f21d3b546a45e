"""How a robot comes to a stand when a run ends: until when that is waited for, and what goes wrong meanwhile."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from py_trees.common import Status

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Mode
from humanoid_bt.session.ending import Ending
from humanoid_bt.session.outcome import End


class Robot:
    """Stands from the first moment on, and is stopped after some ticks if that is asked for."""

    def __init__(self, stops_after: int) -> None:
        self.ticks, self._stops_after, self.asked = 0, stops_after, ""
        self.clock = SimpleNamespace(now=lambda: 0.02 * self.ticks)
        self.supervisor = self
        self.timing = None

    def request_stop(self, _source: str, reason: str) -> None:
        self.asked = reason

    def submit(self, _command: object) -> None: ...

    def advance(self) -> None:
        self.ticks += 1

    def sense(self) -> tuple[Any, Any]:
        stopped = self.asked and self.ticks >= self._stops_after
        return SimpleNamespace(mode=Mode.PROTECTIVE_STOP if stopped else Mode.RUN, base_settled=True), {}


def ending(robot: Robot, told: list[str], halts: Exception | None = None) -> Ending:
    """Return the ending of a run whose tree has ended, or still runs and raises something when it is halted."""

    def halt(_reason: str) -> None:
        if halts is not None:
            raise halts

    commands = SimpleNamespace(release_all=lambda: "nothing")
    runner = SimpleNamespace(robot=commands, ended=None, halt=halt, hold=lambda *_: "nothing")
    runner.status = Status.SUCCESS if halts is None else Status.RUNNING
    nothing = dict.fromkeys(("tree_ended", "happened", "ticked"), lambda *_: None)
    teller = SimpleNamespace(event=lambda _, text: told.append(text), now=0.0, **nothing)
    ticks = SimpleNamespace(begin=lambda: None, finish=lambda _: "")
    parts: list[Any] = [robot, runner, teller, SimpleNamespace(keep=lambda _: None), ticks]
    return Ending(*parts)


@pytest.mark.parametrize(("failure", "ticks"), [("", 1), ("a skill raised", 3)])
def test_a_robot_that_stands_is_left_once_control_has_heard_of_the_stop(failure: str, ticks: int) -> None:
    robot, end = Robot(stops_after=3), End("error" if failure else "success", "why", failure=failure)
    assert ending(robot, []).bring_to_stand(end, moved=True) is end
    assert (robot.ticks, robot.asked) == (ticks, failure)


@pytest.mark.parametrize(("outcome", "after"), [("unfinished", "error"), ("stopped", "stopped")])
def test_an_exception_of_the_halt_is_the_end_of_a_run_that_nothing_else_has_ended(outcome: str, after: str) -> None:
    told: list[str] = []
    halts = HumanoidBtError("it cannot let go")
    end = ending(Robot(stops_after=1), told, halts).bring_to_stand(End(outcome, "why"), moved=True)
    assert end.outcome == after
    assert told == ([] if outcome == "unfinished" else ["it cannot let go"])
