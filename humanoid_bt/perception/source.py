"""Where percepts come from: what every source offers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from humanoid_bt.core.messages import Percept, State


class PerceptSource(Protocol):
    """What sees: called once per perception period."""

    def observe(self, state: State) -> list[Percept]:
        """Return what is published at the state's time."""
        ...

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that it offers and never published so far, and why, as of the last look.

        For people, in a few words: ``hidden``, ``out of range: 4.1 m away, seen up to 3 m``.
        """
        ...
