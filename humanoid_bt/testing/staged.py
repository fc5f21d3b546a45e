"""The engine of a run on the stage: another engine, and between it and the tree what a test brings about."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from humanoid_bt.core.messages import Command, Percept, State
from humanoid_bt.session.engine import Engine


class Staged:
    """An engine that is another one but for what a script does to it: what is not here is asked of that one.

    Args:
        engine: it.

    Attributes:
        percepts: what decision was given at the last tick.
    """

    def __init__(self, engine: Engine) -> None:
        self.engine = engine
        self.percepts: Mapping[str, Percept] = {}

    def __getattr__(self, name: str) -> Any:
        return getattr(self.engine, name)

    def publish(self, status: object, tree: object) -> None:
        """Tell nobody: a test is no run that people look at from outside."""

    def sense(self) -> tuple[State, Mapping[str, Percept]]:
        """Return the state and the latest percepts, for one tick, after what the script does before it."""
        state, self.percepts = self.engine.sense()
        return state, self.percepts

    def submit(self, command: Command) -> None:
        """Give the command of a tick to control."""
        self.engine.submit(command)
