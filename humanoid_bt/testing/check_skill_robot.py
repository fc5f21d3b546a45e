"""The robot as a skill sees it while it is tried: what it commands, reads and writes over is noted."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from humanoid_bt.core.clock import Clock
from humanoid_bt.core.messages import Array, Percept
from humanoid_bt.decision.robot import Commands, Placed, Robot
from humanoid_bt.perception.track import Track
from humanoid_bt.robot.config import RobotConfig


class WatchedRobot(Robot):
    """A robot that lets a skill do what it has not declared, and notes it: so the other rules can be tried, too.

    Args:
        config: the robot's numbers.
        clock: what tells the time.
        raise_estop: called with source and reason.
        unseen: answers with the percepts that were never published, and why.

    Attributes:
        commanded: resources for which targets were set, in the order of the first.
        read: percepts that were asked for, in that order.
    """

    def __init__(
        self,
        config: RobotConfig,
        clock: Clock,
        raise_estop: Callable[[str, str], None],
        unseen: Callable[[], Mapping[str, str]],
    ) -> None:
        super().__init__(config, clock, raise_estop, lambda *_: None, unseen)
        self.commanded: dict[str, None] = {}
        self.read: dict[str, None] = {}
        self._placed: list[tuple[str, Array, Array]] = []

    def grant(self, handle: Commands, resource: str) -> None:
        """Let a node command any resource, and note which."""
        self.commanded[resource] = None
        self._commanding[handle] = None

    def track(self, name: str) -> Track | None:
        """Return the latest percept of this name, and note that it was asked for."""
        self.read[name] = None
        return super().track(name)

    @property
    def overwritten(self) -> list[str]:
        """The percepts whose place a skill has written over."""
        return [name for name, given, kept in self._placed if not np.array_equal(given, kept)]

    def _place(self, percept: Percept, known: Placed | None) -> Placed:
        percept, kept, heading, turn = super()._place(percept, known)
        given = kept.copy()  # can be written to
        self._placed.append((percept.name, given, kept))
        return percept, given, heading, turn
