"""When a tree starts that takes the place of another one."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from humanoid_bt.session.tree_runner import SETTLE_TIME, TreeRunner
from humanoid_bt.tree.ticking.executor import Executor


class Robot:
    """What is asked of the robot."""

    def take_over(self, _other: Robot) -> None: ...

    def begin_tick(self, _state: object, _percepts: object) -> None: ...

    def release_all(self) -> str:
        return "hold"


class Ticks:
    """A tree that says that it is ticked."""

    def __init__(self) -> None:
        self.robot, self.tree = Robot(), SimpleNamespace(nodes=[])

    def tick(self, _state: object, _percepts: object) -> str:
        return "tick"


def at(time: float, *, stands: bool) -> Any:
    return SimpleNamespace(time=time, base_settled=stands)


def new(runner: TreeRunner) -> None:
    runner.replace(cast(Executor, Ticks()))


def test_a_tree_starts_when_the_robot_stands_but_not_before_control_has_heard() -> None:
    runner = TreeRunner(cast(Executor, Ticks()))
    assert cast(str, runner.tick(at(0.0, stands=True), {})) == "tick"
    for begin in (1.0, 20.0):  # the second time as the first
        new(runner)
        assert cast(str, runner.tick(at(begin, stands=True), {})) == "hold"
        assert cast(str, runner.tick(at(begin + 0.02, stands=False), {})) == "hold"
        assert cast(str, runner.tick(at(begin + 0.04, stands=True), {})) == "tick"


def test_a_tree_starts_after_a_while_though_the_robot_does_not_stand() -> None:
    runner = TreeRunner(cast(Executor, Ticks()))
    new(runner)
    ticks = [
        cast(str, runner.tick(at(1.0 + wait, stands=False), {})) for wait in (0, 1, SETTLE_TIME - 0.02, SETTLE_TIME)
    ]
    assert ticks == ["hold", "hold", "hold", "tick"]
