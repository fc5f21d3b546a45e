"""Arms that yield to what pushes them, and go home from it gently."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping
from typing import Protocol

import numpy as np

from humanoid_bt.control.body.references import approach
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import SIDES, Array, HandTarget, Side
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel

_FOLLOW_TIME = 0.2  # s in which the plan of an arm that yields comes to where the arm is
_TAKE_UP_TIME, _TAKES_UP_FOR = 0.1, 0.3  # s, likewise of one that has yielded, and for how long: a jump moves the body
_STIFFEN_TIME = 2.0  # s in which an arm that is soft becomes as stiff as it can be
_STOP = 0.15  # rad before a joint's limit over which it becomes as stiff as it can be, where it is pushed there
_STOP_LEAST = 0.02  # rad, likewise of one that was nearer when it began to yield
_FAR = 1e6  # rad: where the limits of a joint are that has none
_HOMEWARD = 0.2  # share of its stiffness that an arm has at most that goes home from what it touched
_AWAY, _AWAY_TIME, _AWAY_SPEED = 0.10, 1.2, 0.1  # m, s and m/s: that far and long it first moves away from there
_HOME_SPEED = 0.3  # rad/s of its joints afterwards
_HOME = 0.05  # rad from home


class Felt(Protocol):
    """What pushes the robot."""

    @property
    def forces(self) -> Mapping[str, Array]:
        """Group of links -> force, world frame, shape (3,) [N]."""

    def torques_of_carried(self, side: Side) -> Array:
        """Return the torques, shape (nj,), with which the joints hold what a hand carries [Nm]."""


class PlannedJoints(Protocol):
    """A planned motion.

    Attributes:
        still: joints that stay as they are; set it.
    """

    still: list[int]

    @property
    def joints(self) -> Array:
        """Planned angles, shape (nj,) [rad]."""

    def follow(self, joints: list[int], measured: Array, share: float) -> None:
        """Move some joints of the plan toward where they are measured, by a share of the way."""


class YieldingArms:
    """The arms that yield: their plan follows them, and their drives hold them softly.

    What pushes such an arm feels little of a spring, for the spring's rest comes after it, and the damping of the
    drives. Where it was left it stays. Gravity, also of what the hand carries, is held by feedforward. When it yields
    no more its plan is brought to where it is, before it moves again: nothing jumps.

    It yields as far as its joints go, and there its drives stop it, not their mechanical stops: of what those bear
    nothing is felt, and what rebounds from them is felt as a push the other way.

    An arm that nobody wants anywhere then goes home, and what touched it may be in the way: its palm first moves a
    little to where it was pushed, then the arm goes home, slowly and soft all the way.

    Args:
        robot: the robot.
        dynamics: as it is estimated.
        kinematics: its planned motion.
        dt: control period [s].

    Attributes:
        sides: those that yield; set it.
        homeward: those that yielded, and are on their way home.
        stiffness: share of the drives' stiffness, shape (nj,), None where all have all of theirs.
    """

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics, kinematics: PlannedJoints, dt: float) -> None:
        self._joints = {side: robot.arm_joints(side) for side in SIDES if side in robot.config.hands}
        self._least, self._notice = robot.config.contact.stiffness, robot.config.contact.notice
        self._lower, self._upper = np.maximum(robot.lower, -_FAR), np.minimum(robot.upper, _FAR)
        stop = np.minimum(_STOP, (self._upper - self._lower) / 4)
        self._lowest, self._highest = self._lower + stop, self._upper - stop  # where the plan of one that yields ends
        self._dynamics, self._kinematics, self._dt = dynamics, kinematics, dt
        self._count = len(robot.joint_names)
        self.reset()

    def reset(self) -> None:
        """Let all arms be stiff."""
        self.sides: frozenset[Side] = frozenset()
        self._yielded: frozenset[Side] = frozenset()
        self._pushed: dict[Side, Array] = {}  # the largest force on one that yields, shape (3,) [N]
        self._taken_up: dict[Side, float] = {}  # whose plan comes to where they are, and for how long yet [s]
        self._away: dict[Side, tuple[Array, float]] = {}  # where one moves away to, and for how long [m, s]
        self._reference: dict[Side, Array] = {}  # of the joints of one that yields or goes home [rad]
        self.homeward: frozenset[Side] = frozenset()
        self._shares: dict[Side, float] = {}
        self._held: Array = np.zeros(self._count)
        self.stiffness: Array | None = None

    def update(self, qpos: Array, contact: Felt, wanted: Container[str]) -> None:
        """Let arms follow that yield, and those that do not any more become stiff again.

        Args:
            qpos: as it is estimated, shape (7 + nj,).
            contact: knows what the hands carry.
            wanted: the resources that have targets.
        """
        sides = self.sides
        if not (sides or self._shares):
            return
        for side in sides:
            self._taken_up.pop(side, None)
            self._follow(side, qpos[BASE_COORDINATES:], contact.forces[f"{side}_arm"])
        for side in self._yielded - sides:
            self.homeward |= {side}
            self._taken_up[side] = _TAKES_UP_FOR
        for side in list(self._taken_up):
            self._take_up(side, qpos[BASE_COORDINATES:])
        self._kinematics.still = [joint for side in {*sides, *self._taken_up} for joint in self._joints[side]]
        self._yielded = sides
        self.homeward = frozenset(side for side in self.homeward - sides if f"{side}_hand" not in wanted)
        stiffness: Array = np.ones(self._count)
        for side in list(self._shares):
            joints = self._joints[side]
            self._held[joints] = contact.torques_of_carried(side)[joints]
            if side not in sides:
                most = _HOMEWARD if side in self.homeward else 1.0
                self._shares[side] = approach(self._shares[side], most, self._dt / _STIFFEN_TIME)
            stiffness[joints] = np.maximum(self._shares[side], self._stopped(joints, qpos[BASE_COORDINATES:][joints]))
            if self._shares[side] == 1.0 and side not in sides and side not in self._taken_up:
                del self._shares[side]
        self.stiffness = stiffness if self._shares else None

    def _follow(self, side: Side, joints: Array, force: Array) -> None:
        self._shares[side] = self._least
        strength = force @ force
        if strength > self._notice**2:
            self._bring(side, joints, self._dt / _FOLLOW_TIME)
            before = self._pushed.get(side)
            if before is None or strength > before @ before:
                self._pushed[side] = force.copy()

    def _take_up(self, side: Side, joints: Array) -> None:
        """Bring the plan of an arm to where it is, and then let it go."""
        left = self._taken_up.pop(side) - self._dt
        self._bring(side, joints, self._dt / _TAKE_UP_TIME)
        if left > 0:
            self._taken_up[side] = left
            return
        push = self._pushed.pop(side, None)
        if push is not None:
            away = push * (_AWAY / math.sqrt(push @ push))
            self._away[side] = self._dynamics.palm(side) + away, _AWAY_TIME

    def _bring(self, side: Side, joints: Array, share: float) -> None:
        """Move the plan of an arm a share of the way to where it is, but no joint farther to its stop."""
        own = self._joints[side]
        low, high = self._ends(own)
        self._kinematics.follow(own, clamp(joints[own], low, high), share)

    def _ends(self, own: list[int]) -> tuple[Array, Array]:
        """Return between which angles the plan of joints is that yield, shape (len(own),) each [rad]."""
        planned = self._kinematics.joints[own]
        return np.minimum(self._lowest[own], planned), np.maximum(self._highest[own], planned)

    def _stopped(self, own: list[int], measured: Array) -> Array:
        """Return how near to their stops joints were pushed, shape (len(own),): 0 where their plan may be, 1 there."""
        low, high = self._ends(own)
        below = (low - measured) / np.maximum(low - self._lower[own], _STOP_LEAST)
        above = (measured - high) / np.maximum(self._upper[own] - high, _STOP_LEAST)
        return clamp(np.maximum(below, above), 0.0, 1.0)

    def away(self, side: Side) -> HandTarget | None:
        """Return where a palm is to move to, away from what pushed it, None if nowhere; ask once a period."""
        if side not in self._away:
            return None
        place, left = self._away.pop(side)
        if side not in self.homeward or left <= 0:
            return None
        self._away[side] = place, left - self._dt
        return HandTarget(place, speed=_AWAY_SPEED)

    def keep(self, posture: Array, home: Array, hold: bool) -> None:
        """Let home not pull at arms that yield or move away from what they touched, and slowly at those homeward.

        Args:
            posture: of all joints, shape (nj,) [rad]; is changed.
            home: likewise; it is not.
            hold: whether arms stay where they are.
        """
        if not (self.sides or self.homeward):
            return
        planned = self._kinematics.joints
        for side in self.sides | self.homeward:
            joints = self._joints[side]
            if side in self.sides or side in self._away or side in self._taken_up:
                self._reference[side] = planned[joints]
            elif not hold:
                before = self._reference[side]
                step = _HOME_SPEED * self._dt
                self._reference[side] = before + clamp(home[joints] - before, -step, step)
                if np.abs(home[joints] - planned[joints]).max() < _HOME:
                    self.homeward -= {side}
            posture[joints] = self._reference[side]

    def carry(self, torque: Array) -> None:
        """Add to feedforward torques, shape (nj,), what holds a hand that carries something while it is soft."""
        for side, share in self._shares.items():
            joints = self._joints[side]
            torque[joints] += (1.0 - share) * self._held[joints]
