"""Where percepts come from: what every source offers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from humanoid_bt.core.messages import Percept, Truth


class PerceptSource(Protocol):
    """What sees: called once per perception period."""

    def observe(self, robot: Truth) -> list[Percept]:
        """Return what is published now, in the base frame of where the robot really is."""
        ...

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that it offers and never published so far, and why, as of the last look.

        For people, in a few words: ``hidden``, ``out of range: 4.1 m away, seen up to 3 m``.
        """
        ...
