"""The servo (1 kHz): setpoints to joint commands, inside soft limits, speed and torque limits."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.body import Setpoint
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.robot.model import RobotModel

LIMIT_TOLERANCE = 1e-3
"""How far [rad] a setpoint may lie outside the soft limits before it is flagged: solvers overshoot by 1e-6."""

_TOLERANCES = np.array([[LIMIT_TOLERANCE], [0.0], [0.0]])  # of position, velocity, torque


class Servo:
    """Turns setpoints into joint commands.

    Args:
        robot: the robot.

    Attributes:
        position: last validated setpoint, shape (nj,) [rad].
        setpoint: position [rad], velocity [rad/s] and feedforward torque [Nm] of the command in force, shape (3, nj).
        limited: joints whose last setpoint was clamped: soft limit, speed or torque, shape (nj,) of bool.
        clamped: whether any was.
        clamps: how many setpoints were clamped so far.
        commands: how many commands there were so far.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        high = np.array((robot.upper, robot.speed_limit, robot.torque_limit))
        self._low, self._high = -high, high  # of position, which moves along with it, velocity and torque
        self._zeros: Array = np.zeros_like(robot.lower)
        self.position: Array = self._zeros.copy()
        self.limited = np.zeros(len(robot.lower), dtype=bool)
        self.clamped = False
        self.setpoint: Array = np.zeros((3, len(robot.lower)))
        self.clamps = self.commands = 0
        self._hold(self._zeros, self._robot.stiffness, self._robot.damping)

    def reset(self, position: Array) -> None:
        """Start from joint positions, shape (nj,)."""
        self.position = clamp(position, self._robot.lower, self._robot.upper)
        self.limited = np.zeros_like(self.limited)
        self.clamped = False
        self.clamps = 0
        self._hold(self._zeros, self._robot.stiffness, self._robot.damping)

    @property
    def command(self) -> JointCommand:
        """The command in force."""
        return self._command

    def follow(self, setpoint: Setpoint, time: float) -> str:
        """Take a new setpoint, clamped into the limits, if it is finite; otherwise hold the last one.

        Args:
            setpoint: it.
            time: until the next one comes [s]: the speed limit counts on it.

        Returns:
            Why the setpoint was refused, "" when it is in force.
        """
        robot = self._robot
        wanted = np.array((setpoint.position, setpoint.velocity, setpoint.torque))
        if not math.isfinite(wanted.sum()):
            self.hold()
            return "the setpoint is not finite"
        step = time * robot.speed_limit
        np.maximum(robot.lower, self.position - step, out=self._low[0])
        np.minimum(robot.upper, self.position + step, out=self._high[0])
        kept = clamp(wanted, self._low, self._high)
        position, velocity, torque = kept
        outside = np.abs(kept - wanted) > _TOLERANCES
        self.clamped = bool(outside.any())
        self.limited = np.logical_or.reduce(outside)
        self.clamps += self.clamped
        self.position, self.setpoint = position, kept
        stiffness = robot.stiffness if setpoint.stiffness is None else setpoint.stiffness
        damping = robot.damping if setpoint.damping is None else setpoint.damping
        self._drive(JointCommand(position, velocity, stiffness, damping, torque))
        return ""

    def hold(self) -> None:
        """Hold the last validated setpoint at rest, with the torque that carried it, as softly as it was."""
        command = self._command
        self._hold(command.torque, command.stiffness, command.damping)

    def damp(self) -> None:
        """Let go: no stiffness, only joint damping (stop category 0 of IEC 60204-1)."""
        zeros = self._zeros
        if self._command.stiffness is not zeros:
            self.limited = np.zeros_like(self.limited)
            self.clamped = False
            self.setpoint = np.array((self.position, zeros, zeros))
            self._drive(JointCommand(self.position, zeros, zeros, self._robot.damping, zeros))

    def _hold(self, torque: Array, stiffness: Array, damping: Array) -> None:
        self.setpoint = np.array((self.position, self._zeros, torque))
        self._drive(JointCommand(self.position, self._zeros, stiffness, damping, torque))

    def _drive(self, command: JointCommand) -> None:
        self._command = command
        self.commands += 1
