"""The tree that runs, what holds the robot when none does, and how another takes its place."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum, auto

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.messages import Command, Percept, State
from humanoid_bt.decision.robot import Robot
from humanoid_bt.session.outcome import End
from humanoid_bt.tree.ticking.executor import Executor
from humanoid_bt.tree.tree import Tree

SETTLE_TIME = 5.0
"""Time that the robot gets to come to a stand after a tree [s]."""


class _Phase(Enum):
    RUNS = auto()  # the tree is ticked
    SETTLES = auto()  # the robot comes to a stand before the tree starts
    OVER = auto()  # the tree has ended, and another may come


class TreeRunner:
    """Runs one tree, then perhaps others in its place.

    Args:
        executor: of the first tree, set up.

    Attributes:
        ended: how the tree ended that nothing has replaced yet, if the run goes on after it.
        ended_at: engine time of that [s], None before it, and where none has run.
        reporting: path and node of the skills that have results.
    """

    def __init__(self, executor: Executor) -> None:
        self._phase = _Phase.RUNS
        self.ended: End | None = None
        self.ended_at: float | None = None
        self._start_by: float | None = None
        self._take(executor)

    @property
    def tree(self) -> Tree:
        """The tree."""
        return self._executor.tree

    @property
    def robot(self) -> Robot:
        """The robot as the tree sees it."""
        return self._executor.robot

    @property
    def status(self) -> Status:
        """The root's status."""
        return self._executor.status

    @property
    def tip(self) -> Behaviour | None:
        """The deepest node that runs, or ran last; None if none does."""
        return None if self.ended else self.tree.root.tip()

    def tick(self, state: State, percepts: Mapping[str, Percept]) -> Command:
        """Tick the tree and return what it commands, or hold the robot; raises as :meth:`Executor.tick`."""
        if self._phase is _Phase.SETTLES and self._may_start(state):
            self._phase = _Phase.RUNS
        if self._phase is _Phase.RUNS:
            return self._executor.tick(state, percepts)
        return self.hold(state, percepts)

    def hold(self, state: State, percepts: Mapping[str, Percept]) -> Command:
        """Let the robot come to rest and stay there; return the command that does it."""
        self.robot.begin_tick(state, percepts)
        return self.robot.release_all()

    def rest(self, end: End, at: float | None = None) -> None:
        """Hold the robot from the next tick on: the tree has ended.

        Args:
            end: how.
            at: engine time of that [s], None where no tree has run.
        """
        self._phase, self.ended, self.ended_at = _Phase.OVER, end, at

    def halt(self, reason: str) -> None:
        """Halt the tree; raises as :meth:`Executor.halt`."""
        self._executor.halt(reason)

    def replace(self, executor: Executor) -> None:
        """Let another tree start, once the robot stands; the one before it has been halted.

        Args:
            executor: of the other tree, set up on a robot of its own.
        """
        executor.robot.take_over(self.robot)
        self._take(executor)
        self._phase, self._start_by = _Phase.SETTLES, None
        self.ended = self.ended_at = None

    def _take(self, executor: Executor) -> None:
        self._executor = executor
        self.reporting = [(node.path, node.behaviour) for node in executor.tree.nodes if node.type.results]

    def _may_start(self, state: State) -> bool:
        """Return whether the robot stands, or has had its time; control must have heard that all is released."""
        if self._start_by is None:
            self._start_by = state.time + SETTLE_TIME
            return False
        return state.base_settled or state.time >= self._start_by
