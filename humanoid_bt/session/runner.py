"""The tree that runs."""

from __future__ import annotations

from collections.abc import Mapping

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.messages import Command, Percept, State
from humanoid_bt.robot import Robot
from humanoid_bt.tree.executor import Executor
from humanoid_bt.tree.guards import EmergencyStop
from humanoid_bt.tree.tree import Tree


class TreeRunner:
    """Runs one tree.

    Args:
        executor: of the tree, set up.
    """

    def __init__(self, executor: Executor) -> None:
        self._executor = executor
        self._guards = _guards(executor.tree)

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
        """The deepest node that runs."""
        return self.tree.root.tip()

    @property
    def waits_for_reset(self) -> bool:
        """Whether the tree waits for a reset of a latched stop."""
        return any(guard.waits for guard in self._guards)

    def tick(self, state: State, percepts: Mapping[str, Percept]) -> Command:
        """Tick the tree and return what it commands; raises as :meth:`Executor.tick`."""
        return self._executor.tick(state, percepts)

    def hold(self, state: State, percepts: Mapping[str, Percept]) -> Command:
        """Let the robot come to rest and stay there; return the command that does it."""
        self.robot.begin_tick(state, percepts)
        return self.robot.release_all()

    def halt(self, reason: str) -> None:
        """Halt the tree; raises as :meth:`Executor.halt`."""
        self._executor.halt(reason)


def _guards(tree: Tree) -> list[EmergencyStop]:
    return [node.behaviour for node in tree.nodes if isinstance(node.behaviour, EmergencyStop)]
