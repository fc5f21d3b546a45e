"""A run on the stage, tick by tick: as watchers see it while it lasts, and as it is kept."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple, Protocol

from py_trees.common import Status

from humanoid_bt.control.supervisor import Stop
from humanoid_bt.core.messages import Command, Percept, State, Truth
from humanoid_bt.decision.result import ResultValue
from humanoid_bt.decision.robot import Robot
from humanoid_bt.perception.track import Track
from humanoid_bt.robot.config import RobotConfig
from humanoid_bt.session.report import Report
from humanoid_bt.testing.course import Missed
from humanoid_bt.testing.expectations import expect
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree


class Sample(NamedTuple):
    """What is kept of a tick.

    Attributes:
        state: what it saw of the robot.
        percepts: the latest percept of each name.
        command: what it commanded, None if a node raised an exception.
        changes: the nodes whose status it changed.
        keys: value of every key of the tree's blackboard that has one, by name.
        results: what the skills that ran in it have reported by then: path -> name -> value, in SI units.
        truth: where the robot really was, None in a dry run.
        touched: names of the scene's objects that the robot has touched by then.
        bumped: of those, the ones that no hand was sent to.
    """

    state: State
    percepts: Mapping[str, Percept]
    command: Command | None
    changes: tuple[NodeChange, ...]
    keys: Mapping[str, Any]
    results: Mapping[str, Mapping[str, ResultValue]]
    truth: Truth | None
    touched: tuple[str, ...]
    bumped: tuple[str, ...]


class View:
    """What a watcher sees after a tick: one view for the whole run, which moves on.

    Attributes:
        tree: the tree that runs.
        robot: the robot as the tree sees it: on it expressions are evaluated.
        sample: what is kept of the tick.
        statuses: the status of every node by its path, after the tick.
    """

    def __init__(self, tree: Tree, robot: Robot) -> None:
        self.tree, self.robot = tree, robot
        self.statuses: dict[str, Status] = {node.path: Status.INVALID for node in tree.nodes}
        self.sample: Sample

    @property
    def time(self) -> float:
        """Engine time of the tick [s]."""
        return self.sample.state.time

    @property
    def state(self) -> State:
        """What the tick saw of the robot."""
        return self.sample.state

    @property
    def command(self) -> Command | None:
        """What the tick commanded, None if a node raised an exception."""
        return self.sample.command

    @property
    def changes(self) -> Sequence[NodeChange]:
        """The nodes whose status the tick changed, in the order in which they were ticked."""
        return self.sample.changes

    @property
    def results(self) -> Mapping[str, Mapping[str, ResultValue]]:
        """What the skills that ran in it have reported by then: path -> name -> value, in SI units."""
        return self.sample.results

    @property
    def touched(self) -> Sequence[str]:
        """Names of the scene's objects that the robot has touched by then, with a hand, a foot or any other link."""
        return self.sample.touched

    @property
    def bumped(self) -> Sequence[str]:
        """Names of those of them that it touched without a hand having been sent there."""
        return self.sample.bumped

    @property
    def tracks(self) -> Mapping[str, Track]:
        """What has been seen so far by name, as skills see it."""
        return self.robot.tracks

    def status(self, node: str) -> Status:
        """Return the status of a node, INVALID if it was not reached or is halted.

        Args:
            node: its path, or the end of it.

        Raises:
            UserError: there is none, or more than one.
        """
        return self.statuses[self.tree.node(node).path]

    def move_on(self, sample: Sample) -> None:
        """Take another tick."""
        self.sample = sample
        for change in sample.changes:
            self.statuses[change.path] = change.status


class Watcher(Protocol):
    """What looks on while a tree runs on the stage: an expectation, a measure of coverage."""

    def tick(self, view: View) -> None:
        """Look, after a tick. The view moves on: what is needed later is to be taken from it now."""

    def end(self, run: TreeRun) -> None:
        """Look at the whole, once the robot has come to a stand."""


@dataclass(frozen=True, repr=False)
class TreeRun:
    """What a tree did on the stage.

    Attributes:
        report: the run's report.
        tree: the tree, with its nodes as they were at the end.
        samples: every tick.
        changes: every change of a node's status.
        stops: every stop the supervisor ordered.
        config: the robot's numbers.
        missed: the events of the script that never happened.
    """

    report: Report
    tree: Tree
    samples: Sequence[Sample] = field(repr=False)
    changes: Sequence[NodeChange] = field(repr=False)
    stops: Sequence[Stop]
    config: RobotConfig = field(repr=False)
    missed: Sequence[Missed] = ()

    @property
    def outcome(self) -> str:
        """How it ended: success, failure, stopped, error, unfinished or interrupted."""
        return self.report.outcome

    @property
    def reason(self) -> str:
        """Why, in words."""
        return self.report.reason

    @property
    def time(self) -> float:
        """Simulated time from the first tick until the tree ended [s]."""
        return self.report.sim_time

    @property
    def fell(self) -> bool:
        """Whether the robot fell, also if that was after the tree had ended."""
        return self.report.fell

    @property
    def succeeded(self) -> bool:
        """Whether the tree ended with SUCCESS."""
        return self.outcome == "success"

    @property
    def failed(self) -> bool:
        """Whether the tree ended with FAILURE."""
        return self.outcome == "failure"

    @property
    def trace(self) -> str:
        """SHA-256 over all states, commands and node changes: two runs that did the same have the same."""
        return self.report.trace_hash

    @property
    def recording(self) -> Path | None:
        """The recording, if there is one."""
        return Path(self.report.recording) if self.report.recording else None

    @property
    def states(self) -> list[State]:
        """The state at every tick."""
        return [sample.state for sample in self.samples]

    @property
    def truths(self) -> list[Truth]:
        """Where the robot really was at every tick, which nobody told it; empty after a dry run."""
        return [sample.truth for sample in self.samples if sample.truth is not None]

    @property
    def commands(self) -> list[Command | None]:
        """The command of every tick."""
        return [sample.command for sample in self.samples]

    def views(self) -> Iterator[View]:
        """Yield what watchers saw, tick by tick: with it a run is judged once it is over.

        Meanwhile the keys of the tree have the values that they had then.
        """
        clock = _Then()
        view = View(self.tree, Robot(self.config, clock))
        for sample in self.samples:
            clock.time = sample.state.time
            view.robot.begin_tick(sample.state, sample.percepts)
            for key in self.tree.keys:
                key.put(sample.keys[key.name]) if key.name in sample.keys else key.clear()
            view.move_on(sample)
            yield view

    def expect(self, *texts: str) -> None:
        """Judge it by expectations: ``run.expect("within 20 s: outcome == success", "never: fell")``.

        Args:
            texts: them, in the language of scenario files.

        Raises:
            AssertionError: it has not met all of them; with the moment and the values then.
            UserError: a text is no expectation.
        """
        __tracebackhide__ = True
        expect(self, texts, {*self.report.percepts, *self.report.unseen})

    def __repr__(self) -> str:
        return repr(self.report)


class _Then:
    """The clock of a run that is looked at again."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        """Return the time of the tick that is looked at [s]."""
        return self.time
