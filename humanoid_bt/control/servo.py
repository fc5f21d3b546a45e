"""The servo (1 kHz): setpoints to joint commands, inside soft limits, speed and torque limits."""

from __future__ import annotations

import numpy as np

from humanoid_bt.control.body.whole_body import Setpoint
from humanoid_bt.core.clock import WHOLE_BODY_PERIOD
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.robot.model import RobotModel

LIMIT_TOLERANCE = 1e-3
"""How far [rad] a setpoint may lie outside the soft limits before it is flagged: solvers overshoot by 1e-6."""


class Servo:
    """Turns setpoints into joint commands.

    Args:
        robot: the robot.

    Attributes:
        position: last validated setpoint, shape (nj,) [rad].
        limited: joints whose last setpoint was clamped: soft limit, speed or torque, shape (nj,) of bool.
        clamps: how many setpoints were clamped so far.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        self._step = robot.speed_limit * WHOLE_BODY_PERIOD
        self._zeros: Array = np.zeros_like(robot.lower)
        self.position: Array = self._zeros.copy()
        self.limited = np.zeros(len(robot.lower), dtype=bool)
        self.clamps = 0
        self._command = self._hold()

    def reset(self, position: Array) -> None:
        """Start from joint positions, shape (nj,)."""
        self.position = clamp(position, self._robot.lower, self._robot.upper)
        self.limited = np.zeros_like(self.limited)
        self.clamps = 0
        self._command = self._hold()

    @property
    def command(self) -> JointCommand:
        """The command in force."""
        return self._command

    def follow(self, setpoint: Setpoint) -> str:
        """Take a new setpoint, clamped into the limits, if it is finite; otherwise hold the last one.

        Call it once per whole-body period: the speed limit counts on it.

        Returns:
            Why the setpoint was refused, "" when it is in force.
        """
        robot = self._robot
        values = (setpoint.position, setpoint.velocity, setpoint.torque)
        if not all(np.isfinite(value).all() for value in values):
            self.hold()
            return "the setpoint is not finite"
        slow = clamp(setpoint.position, self.position - self._step, self.position + self._step)
        inside = clamp(slow, robot.lower, robot.upper)
        velocity = clamp(setpoint.velocity, -robot.speed_limit, robot.speed_limit)
        torque = clamp(setpoint.torque, -robot.torque_limit, robot.torque_limit)
        self.limited = (
            (np.abs(inside - setpoint.position) > LIMIT_TOLERANCE)
            | (velocity != setpoint.velocity)
            | (torque != setpoint.torque)
        )
        self.clamps += int(self.limited.any())
        self.position = inside
        self._command = JointCommand(inside, velocity, robot.stiffness, robot.damping, torque)
        return ""

    def hold(self) -> None:
        """Hold the last validated setpoint at rest, with the torque that carried it."""
        self._command = self._hold(self._command.torque)

    def damp(self) -> None:
        """Let go: no stiffness, only joint damping (stop category 0 of IEC 60204-1)."""
        zeros = self._zeros
        if self._command.stiffness is not zeros:
            self.limited = np.zeros_like(self.limited)
            self._command = JointCommand(self.position, zeros, zeros, self._robot.damping, zeros)

    def _hold(self, torque: Array | None = None) -> JointCommand:
        robot = self._robot
        feedforward = self._zeros if torque is None else torque
        return JointCommand(self.position, self._zeros, robot.stiffness, robot.damping, feedforward)
