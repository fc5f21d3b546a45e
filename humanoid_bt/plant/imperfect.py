"""A plant that is not what control takes it for: commands come late, encoders are off."""

from __future__ import annotations

from collections import deque
from dataclasses import replace

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.messages import Array, JointCommand, Reading
from humanoid_bt.plant.interface import Plant


class ImperfectPlant:
    """A plant behind a slow bus and bad encoders; as good as the plant itself until it is altered.

    Args:
        plant: the plant.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self.alter()

    def alter(self, delay: float = 0.0, encoders: Array | None = None) -> None:
        """Let it differ from what control takes it for, in a run that begins now.

        Args:
            delay: from when control commands something until the drives hear of it [s], in whole servo periods. The
                drives' own loops are as quick as before.
            encoders: what each encoder shows too much, to control and to its drive alike, shape (nj,) [rad]; nothing
                if None.
        """
        self._late = round(delay / SERVO_PERIOD)
        self._encoders = encoders
        self._coming: deque[JointCommand] = deque()
        self._given: JointCommand | None = None  # the latest command,
        self._held: JointCommand | None = None  # and where joints come to rest that hold their encoders there

    def measure(self, into: Reading | None = None) -> Reading:
        """Return what the sensors say now, as :class:`~humanoid_bt.plant.interface.Plant` wants it."""
        reading = self._plant.measure(into)
        if self._encoders is not None:
            reading.joint_position += self._encoders
        return reading

    def step(self, command: JointCommand) -> None:
        """Drive the joints for one servo period."""
        if self._encoders is not None:
            if self._held is None or command is not self._given:
                self._given, self._held = command, replace(command, position=command.position - self._encoders)
            command = self._held
        if self._late:
            self._coming.extend([command] * (1 if self._coming else self._late + 1))
            command = self._coming.popleft()
        self._plant.step(command)
