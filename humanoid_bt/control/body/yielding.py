"""Arms that yield to what pushes them, and become stiff again without a jump."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from humanoid_bt.control.body.inverse_kinematics import InverseKinematics
from humanoid_bt.control.body.references import approach
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel

_FOLLOW_TIME = 0.2  # s in which the plan of an arm that yields comes to where the arm is
_STIFFEN_TIME = 2.0  # s; it goes home meanwhile, and may still be at what pushed it


class Felt(Protocol):
    """What pushes the robot."""

    @property
    def forces(self) -> Mapping[str, Array]:
        """Group of links -> force, world frame, shape (3,) [N]."""

    def torques_of_carried(self, side: Side) -> Array:
        """Return the torques, shape (nj,), with which the joints hold what a hand carries [Nm]."""


class YieldingArms:
    """The arms that yield: their plan follows them, and their drives hold them softly.

    What pushes such an arm feels little of a spring, for the spring's rest comes after it, and the damping of the
    drives. Where it was left it stays. Gravity, also of what the hand carries, is held by feedforward. When the arm is
    stiff again its plan is where it is: nothing jumps.

    Args:
        robot: the robot.
        kinematics: its planned motion.
        dt: control period [s].

    Attributes:
        sides: those that yield; set it.
        stiffness: share of the drives' stiffness, shape (nj,), None where all have all of theirs.
    """

    def __init__(self, robot: RobotModel, kinematics: InverseKinematics, dt: float) -> None:
        self._joints = {side: robot.arm_joints(side) for side in SIDES if side in robot.config.hands}
        self._least, self._notice = robot.config.contact.stiffness, robot.config.contact.notice
        self._kinematics, self._dt = kinematics, dt
        self._count = len(robot.joint_names)
        self.reset()

    def reset(self) -> None:
        """Let all arms be stiff."""
        self.sides: frozenset[Side] = frozenset()
        self._shares: dict[Side, float] = {}
        self._held: Array = np.zeros(self._count)
        self.stiffness: Array | None = None

    def update(self, qpos: Array, contact: Felt) -> None:
        """Let arms follow that yield, and those that do not any more become stiff again.

        Args:
            qpos: as it is estimated, shape (7 + nj,).
            contact: knows what the hands carry.
        """
        sides = self.sides
        if not (sides or self._shares):
            return
        self._kinematics.still = [joint for side in sides for joint in self._joints[side]]
        for side in sides:
            self._shares[side] = self._least
            joints, force = self._joints[side], contact.forces[f"{side}_arm"]
            if force @ force > self._notice**2:
                self._kinematics.follow(joints, qpos[BASE_COORDINATES:][joints], self._dt / _FOLLOW_TIME)
            self._held[joints] = contact.torques_of_carried(side)[joints]
        for side in self._shares.keys() - sides:
            self._shares[side] = approach(self._shares[side], 1.0, self._dt / _STIFFEN_TIME)
            if self._shares[side] == 1.0:
                del self._shares[side]
        stiffness: Array = np.ones(self._count)
        for side, share in self._shares.items():
            stiffness[self._joints[side]] = share
        self.stiffness = stiffness if self._shares else None

    def keep(self, posture: Array) -> None:
        """Let the posture, shape (nj,), of arms that yield be what is planned: home does not pull at them."""
        for side in self.sides:
            posture[self._joints[side]] = self._kinematics.joints[self._joints[side]]

    def carry(self, torque: Array) -> None:
        """Add to feedforward torques, shape (nj,), what holds a hand that carries something while it is soft."""
        for side, share in self._shares.items():
            joints = self._joints[side]
            torque[joints] += (1.0 - share) * self._held[joints]
