"""The plant's own watchdog: what the drives get when nobody commands them any more."""

from __future__ import annotations

import numpy as np

from humanoid_bt.cable.payloads import PlantState
from humanoid_bt.cable.safe_state import LET_GO, WATCHDOG, SafeState
from humanoid_bt.core.clock import cycles
from humanoid_bt.core.messages import JointCommand


class PlantWatchdog:
    """Says in every servo cycle what the drives get: the last command, or the safe state.

    Args:
        timeout: silence after which the safe state follows [s].
        safe: hold the last position with the stiffness and torque that it had, or brake without any stiffness.

    Attributes:
        state: what it does.
        silent: servo cycles since the last command.
    """

    def __init__(self, timeout: float = WATCHDOG, safe: SafeState = "hold") -> None:
        self._timeout, self._let_go = cycles(timeout), max(cycles(LET_GO), cycles(timeout))
        self._safe = PlantState.HOLDS if safe == "hold" else PlantState.DAMPS
        self._command: JointCommand | None = None
        self.state = PlantState.WAITS
        self.silent = 0

    @property
    def lost(self) -> bool:
        """Whether the driver was silent for so long that it is none any more."""
        return self.silent > self._let_go

    def reset(self) -> None:
        """Begin with a robot that nobody has commanded so far."""
        self._command = None
        self.state = PlantState.WAITS
        self.silent = 0

    def follow(self, command: JointCommand) -> None:
        """Take a command."""
        self._command = command
        self.state = PlantState.FOLLOWS
        self.silent = 0

    def be_safe(self) -> None:
        """Go to the safe state at once."""
        if self._command is None or self.state is self._safe:
            return
        self.state = self._safe
        command, zeros = self._command, np.zeros_like(self._command.position)
        if self._safe is PlantState.HOLDS:
            stiffness, torque = command.stiffness, command.torque
        else:
            stiffness = torque = zeros
        self._command = JointCommand(command.position, zeros, stiffness, command.damping, torque)

    def command(self) -> JointCommand | None:
        """Return what the drives get in this servo cycle, None before the first command; call it once a cycle."""
        self.silent += 1
        if self.silent > self._timeout:
            self.be_safe()
        return self._command
