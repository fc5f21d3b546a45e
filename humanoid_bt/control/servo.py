"""The servo (1 kHz): setpoints to joint commands, inside soft limits, speed and torque limits."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.control.body.body import Setpoint
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import Array, JointCommand
from humanoid_bt.robot.model import RobotModel

LIMIT_TOLERANCE = 1e-3
"""How far [rad] a setpoint may lie outside the soft limits before it is flagged: solvers overshoot by 1e-6."""

_IN_LIMITS, _OVERSHOT, _CLAMPED, _NOT_FINITE, _NEGATIVE = range(5)  # what is found of a setpoint ...
_WHY = {_NOT_FINITE: "the setpoint is not finite", _NEGATIVE: "the setpoint has negative gains"}  # ... that is refused


class Servo:
    """Turns setpoints into joint commands.

    Args:
        robot: the robot.

    Attributes:
        position: last validated setpoint, shape (nj,) [rad].
        setpoint: position [rad], velocity [rad/s] and feedforward torque [Nm] of the command in force, shape (3, nj).
        limited: joints whose last setpoint was clamped: soft limit, speed or torque, shape (nj,) of bool.
        clamped: whether any was.
        commands: how often there was a command so far, the same one again included.
    """

    def __init__(self, robot: RobotModel) -> None:
        self._robot = robot
        self._zeros: Array = np.zeros_like(robot.lower)
        self.position: Array = self._zeros.copy()
        self.limited = np.zeros(len(robot.lower), dtype=bool)
        self.clamped = False
        self.setpoint: Array = np.zeros((3, len(robot.lower)))
        self.commands = 0
        self._in_force: Setpoint | None = None  # the last setpoint, if no limit has changed anything of it
        self._hold(self._zeros, self._robot.stiffness, self._robot.damping)

    def reset(self, position: Array) -> None:
        """Start from joint positions, shape (nj,)."""
        self.position = clamp(position, self._robot.lower, self._robot.upper)
        self.limited = np.zeros_like(self.limited)
        self.clamped = False
        self._hold(self._zeros, self._robot.stiffness, self._robot.damping)

    @property
    def command(self) -> JointCommand:
        """The command in force."""
        return self._command

    def follow(self, setpoint: Setpoint, time: float) -> str:
        """Take a setpoint, clamped into the limits; hold the last one if it is not finite, or has negative gains.

        What is in force as a whole and comes again leaves the drives their command.

        Args:
            setpoint: it.
            time: until the next one comes [s]: the speed limit counts on it.

        Returns:
            Why the setpoint was refused, "" when it is in force.
        """
        if setpoint is self._in_force:
            self.commands += 1
            return ""
        robot = self._robot
        kept, limited = np.empty((3, len(robot.lower))), np.empty(len(robot.lower), dtype=bool)
        stiffness = robot.stiffness if setpoint.stiffness is None else setpoint.stiffness
        damping = robot.damping if setpoint.damping is None else setpoint.damping
        found = _clamped(
            setpoint.position, setpoint.velocity, setpoint.torque, stiffness, damping, self.position, time,
            robot.lower, robot.upper, robot.speed_limit, robot.torque_limit, kept, limited,
        )  # fmt: skip
        if found in _WHY:
            self.hold()
            return _WHY[found]
        self.clamped, self.limited = found == _CLAMPED, limited
        self.position, self.setpoint = kept[0], kept
        self._drive(JointCommand(self.position, kept[1], stiffness, damping, kept[2]))
        if found == _IN_LIMITS:
            self._in_force = setpoint
        return ""

    @property
    def moves(self) -> bool:
        """Whether the command in force moves any joint."""
        return bool(self._command.velocity.any())

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
        self._in_force = None
        self.commands += 1


@compiled(
    "i8(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8, f8[::1], f8[::1], f8[::1], f8[::1], f8[:, ::1],"
    " b1[::1])"
)
def _clamped(
    position: Array,
    velocity: Array,
    torque: Array,
    stiffness: Array,
    damping: Array,
    before: Array,
    time: float,
    lower: Array,
    upper: Array,
    speed_limit: Array,
    torque_limit: Array,
    kept: Array,
    limited: NDArray[np.bool_],
) -> int:
    """Write a setpoint as far as it is within all limits, and which joints it was not for; return what was found.

    Args:
        position, velocity, torque, stiffness, damping: the setpoint.
        before: position of the last one.
        time: in which it is followed [s].
        lower, upper, speed_limit, torque_limit: the limits.
        kept: position, velocity and torque within them.
        limited: whether a limit has changed that by more than a solver's error.
    """
    found = _IN_LIMITS
    for joint in range(len(position)):
        gains = stiffness[joint] + damping[joint]
        if not math.isfinite(position[joint] + velocity[joint] + torque[joint] + gains):
            return _NOT_FINITE
        if min(stiffness[joint], damping[joint]) < 0:
            return _NEGATIVE
        way, speed, most = time * speed_limit[joint], speed_limit[joint], torque_limit[joint]
        low, high = max(lower[joint], before[joint] - way), min(upper[joint], before[joint] + way)
        kept[0, joint] = min(max(position[joint], low), high)
        kept[1, joint] = min(max(velocity[joint], -speed), speed)
        kept[2, joint] = min(max(torque[joint], -most), most)
        limited[joint] = (
            abs(kept[0, joint] - position[joint]) > LIMIT_TOLERANCE
            or kept[1, joint] != velocity[joint]
            or kept[2, joint] != torque[joint]
        )
        if limited[joint]:
            found = _CLAMPED
        elif found == _IN_LIMITS and kept[0, joint] != position[joint]:
            found = _OVERSHOT
    return found
