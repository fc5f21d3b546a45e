"""Where percepts come from: what every source offers."""

from __future__ import annotations

from typing import Protocol

from humanoid_bt.core.messages import Percept, State


class PerceptSource(Protocol):
    """What sees: called once per perception period."""

    def observe(self, state: State) -> list[Percept]:
        """Return what is published at the state's time."""
        ...
