"""What a tree decides on recorded states and percepts: decision alone, as fast as it goes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.core.messages import Mode, Percept
from humanoid_bt.decision.robot import Robot
from humanoid_bt.realtime.remote_supervisor import StateClock
from humanoid_bt.record.reading import FlightLog, News
from humanoid_bt.record.tick import Tick
from humanoid_bt.review.compare_run import Parting, command_parting, node_parting
from humanoid_bt.review.recorded_calls import RecordedCalls
from humanoid_bt.review.recorded_run import TO_TREE, RecordedRun
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.session.blackboard import Blackboard
from humanoid_bt.session.setting import setting
from humanoid_bt.tree.ticking.deciding import reason_of
from humanoid_bt.tree.ticking.executor import Executor, NodeChange
from humanoid_bt.tree.ticking.forcing import force
from humanoid_bt.tree.tree import Tree

_AT = 1e-9  # s; engine times are sums of floats


@dataclass
class Done:
    """What came of running something again.

    Attributes:
        difference: where it first differs from what was recorded.
        ticks: how many were run.
        duration: simulated time of them [s].
        outcome: how the tree ended.
        reason: why, in words.
        notes: what was not compared, and why.
    """

    difference: Parting | None = None
    ticks: int = 0
    duration: float = 0.0
    outcome: str = "unfinished"
    reason: str = "the tree still ran where the recording ends"
    notes: list[str] = field(default_factory=list)


def decide_again(log: FlightLog, run: RecordedRun, tree: Tree, robot: Path) -> Done:
    """Tick a tree on what was recorded, until it ends or the recording does.

    Args:
        log: what was recorded.
        run: what it says about its run.
        tree: to tick, which no session had before.
        robot: file of the robot.

    Raises:
        UserError: the tree needs what the robot does not have.
        NodeError: a skill raised an exception in ``setup``.
    """
    done, clock, unseen = Done(), StateClock(), dict[str, str]()
    changes: list[NodeChange] = []
    timeline: list[NodeChange] = []
    calls = RecordedCalls()
    view = Robot(load_robot_config(robot), clock, lambda *_: None, lambda *_: None, lambda: unseen, calls=calls)
    executor = Executor(tree, view, changes.append)
    executor.setup()
    inputs, percepts, first = _Recorded(log, run), dict[str, Percept](), None
    for tick, news in inputs.ticks():
        clock.time = tick.state.time
        first = clock.time if first is None else first
        done.ticks, done.duration = done.ticks + 1, clock.time - first
        percepts |= {percept.name: percept for percept in tick.percepts}
        for one in news:
            if one.kind == "unseen":
                unseen.clear()
                unseen.update(one.value)
            if one.kind == "input" and one.value[1] in TO_TREE:
                do_again(tree, one.value[1], one.value[2], begun=done.ticks > 1)
            if one.kind == "input" and one.value[1] == "answer":
                calls.hear(one.value[2])
        changes.clear()
        try:
            command = executor.tick(tick.state, percepts)
        except HumanoidBtError as error:
            command, done.outcome, done.reason = None, "error", str(error)
        timeline += changes
        if done.difference is None:
            last = clock.time >= inputs.until - _AT
            differ = _nodes_differ(clock.time, news, changes, last)
            done.difference = differ or command_parting(clock.time, tick.command, command)
        if command is None:
            break
        if executor.status is not Status.RUNNING:
            done.outcome = "success" if executor.status is Status.SUCCESS else "failure"
            done.reason = reason_of(timeline)
            break
    if inputs.broken_off:
        done.notes.append(inputs.broken_off)
    return done


def is_paused(tick: Tick) -> bool:
    """Return whether control held the robot, or was to, because somebody paused the run."""
    return tick.state.mode is Mode.PAUSED or (tick.command is not None and tick.command.pause is not None)


def do_again(tree: Tree, kind: str, told: list[Any], begun: bool) -> None:
    """Do to a tree what was done to it from outside; what it has no key, parameter or node for is left alone.

    Args:
        tree: the tree.
        kind: one of ``TO_TREE``.
        told: what was done, as an input has it.
        begun: whether the tree has been ticked.
    """
    with suppress(UserError):
        match kind, told:
            case "key", [name]:
                del Blackboard(tree.keys, begun)[name]
            case "key", [name, value]:
                Blackboard(tree.keys, begun)[name] = value
            case "set", [name, value]:
                setting(tree, name, value).apply()
            case "force", [path, status, why]:
                force(tree.node(path).behaviour, Status[status], why)


class _Recorded:
    """Ticks of a tree, with the news of each.

    Attributes:
        until: engine time at which the tree ended [s].
        broken_off: why nothing comes from some time on, "" if all came.
    """

    def __init__(self, log: FlightLog, run: RecordedRun) -> None:
        self._log = log
        self.broken_off = ""
        self.until = run.tree_ended

    def ticks(self) -> Iterator[tuple[Tick, list[News]]]:
        """Yield the ticks up to the tree's end."""
        news, last = iter(self._log.news), None
        waiting: list[News] = []
        for tick in self._log.ticks():
            if tick.state.time > self.until + _AT:
                return
            if is_paused(tick):
                self.broken_off = f"somebody paused the run at {tick.state.time:.2f} s: the rest is not compared"
                return
            while last is None or last.time <= tick.state.time + _AT:
                if last is not None:
                    waiting.append(last)
                last = next(news, None)
                if last is None:
                    last = News(float("inf"), "", None)
            if any(one.kind == "tree" for one in waiting):
                self.broken_off = f"the tree was edited at {tick.state.time:.2f} s: the rest is not compared"
                return
            yield tick, waiting
            waiting = []


def _nodes_differ(now: float, news: list[News], changes: list[NodeChange], last: bool) -> Parting | None:
    """Return the first node that changed otherwise, None if all did as recorded."""
    nodes = [one.value for one in news if one.kind == "node" and abs(one.time - now) < _AT]
    before = [(path, status) for path, status, _ in nodes]
    after = [(change.path, change.status.name) for change in changes]
    if last and all(status == Status.INVALID.name for _, status in before[len(after) :]):
        del before[len(after) :]  # a tree that is halted when its run ends is halted after its last tick
    for index in range(max(len(before), len(after))):
        one = before[index] if index < len(before) else None
        other = after[index] if index < len(after) else None
        if one != other:
            return node_parting(now, one, other)
    return None
