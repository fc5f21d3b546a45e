"""What control drives, simulated or real: the boundary that a robot's driver implements."""

from __future__ import annotations

from typing import Protocol

from humanoid_bt.core.messages import JointCommand, Reading


class Plant(Protocol):
    """What the servo drives: a simulation or a real robot."""

    def measure(self, into: Reading | None = None) -> Reading:
        """Return what the sensors say now.

        Args:
            into: whose arrays are filled and returned, instead of new ones; its time counts for nothing.
        """
        ...

    def step(self, command: JointCommand) -> None:
        """Drive the joints for one servo period."""
        ...
