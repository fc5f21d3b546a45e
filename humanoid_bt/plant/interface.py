"""What control drives, simulated or real: the boundary that a robot's driver implements."""

from __future__ import annotations

from typing import Protocol

from humanoid_bt.core.messages import JointCommand, Reading

SILENT_AFTER = 0.020
"""Age of a reading [s] after which control takes the plant for silent, and does not believe the reading any more."""


class Plant(Protocol):
    """What the servo drives: a simulation or a real robot."""

    @property
    def fault(self) -> str:
        """Why the plant cannot be relied on now, as when a cable is pulled; "" while it can."""
        ...

    def measure(self, into: Reading | None = None) -> Reading:
        """Return what the sensors say now.

        Args:
            into: whose arrays are filled and returned, instead of new ones; its time and age count for nothing.
        """
        ...

    def step(self, command: JointCommand) -> None:
        """Drive the joints for one servo period."""
        ...
