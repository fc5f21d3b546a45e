"""An arm that gets stuck on the way to how its palm is to be turned is brought to other angles, and goes on from there.

A palm turns the shortest way. That may end where a joint does, or where own links meet, although the arm could hold the
palm so: its elbow would have to be on the other side.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from humanoid_bt.control.body.inverse_kinematics import InverseKinematics
from humanoid_bt.core.geometry import turn_between, turn_of_axis
from humanoid_bt.core.messages import ArmTarget, Array, HandTarget, Pointing, Side, Target
from humanoid_bt.core.palm import turn_left
from humanoid_bt.robot.model import RobotModel

_THERE = 0.01, math.radians(2)  # m, rad from its target at which a palm is not stuck
_WORTH = 0.2  # m/rad: how far a palm must come to make up for being turned away by one more radian
_PROGRESS = 0.01  # m that a palm comes nearer, so weighed, while it is not stuck; less when it is to be slow
_PATIENCE = 0.4  # s without progress after which it is
_STEPS = 3  # of the search in a control period
_ARRIVED = 0.1  # rad from the angles that were found at which the palm goes on
_LONGEST = 4.0  # s for the way to them
_TRIES = 3
_SAME = 0.02, 0.1  # m, rad within which a target is the same as before


class Rearranging:
    """One arm.

    Args:
        robot: the robot.
        kinematics: its planned motion.
        side: of the arm.
        dt: control period [s].
    """

    def __init__(self, robot: RobotModel, kinematics: InverseKinematics, side: Side, dt: float) -> None:
        self._kinematics, self._side, self._dt = kinematics, side, dt
        self._search = kinematics.arm_search(side)
        self._joints = robot.arm_joints(side)
        self._names = [robot.joint_names[joint] for joint in self._joints]
        self._target: HandTarget | None = None
        self.reset()

    def reset(self) -> None:
        """Begin anew: there is no target."""
        self._target = None
        self._angles: Array | None = None  # to which the arm goes
        self._searches = False
        self._tries, self._since, self._best = 0, 0.0, math.inf

    def update(self, target: Target | None, upright: Callable[[], Array]) -> ArmTarget | None:
        """Return to which angles the arm shall go first; None if it shall do as it is asked.

        Args:
            target: what it is asked; None for nothing.
            upright: answers with the configuration in which the body would be without the hand, shape (7 + nj,).
        """
        if not isinstance(target, HandTarget) or target.orientation is None or target.relative or target.press:
            if self._target is not None:
                self.reset()
            return None
        if self._target is None or not _is_same(self._target, target):
            self.reset()
            self._target = target
        self._since += self._dt
        if self._angles is not None:
            away = np.abs(self._kinematics.joints[self._joints] - self._angles).max()
            if away > _ARRIVED and self._since < _LONGEST:
                return ArmTarget(dict(zip(self._names, self._angles.tolist(), strict=True)))
            self._angles, self._since, self._best = None, 0.0, math.inf
        if self._searches:
            self._go_on()
        elif self._tries < _TRIES and self._is_stuck(target):
            if not self._tries:
                self._search.begin(upright(), target)
            self._searches = True
        return None

    def _is_stuck(self, target: HandTarget) -> bool:
        assert target.orientation is not None
        away = math.dist(target.position.tolist(), self._kinematics.palm(self._side).tolist())
        turned = turn_left(self._kinematics.palm_frame(self._side), target.orientation)
        off = away + _WORTH * turned
        progress = _PROGRESS if target.speed is None else min(_PROGRESS, target.speed * _PATIENCE / 4)
        if off < self._best - progress or (away < _THERE[0] and turned < _THERE[1]):
            self._best, self._since = min(off, self._best), 0.0
        return self._since > _PATIENCE

    def _go_on(self) -> None:
        self._angles = self._search.go_on(_STEPS)
        if self._angles is not None:
            self._searches, self._since = False, 0.0
            self._tries += 1
        elif self._search.over:
            self._searches, self._tries = False, _TRIES


def _is_same(before: HandTarget, now: HandTarget) -> bool:
    one, other = before.orientation, now.orientation
    if isinstance(one, Pointing) and isinstance(other, Pointing):
        turn = turn_of_axis(one.direction, other.direction) if one.axis == other.axis else np.full(3, np.inf)
    elif isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        turn = turn_between(one, other)
    else:
        return False
    near = math.dist(before.position.tolist(), now.position.tolist()) < _SAME[0]
    return near and float(np.linalg.norm(turn)) < _SAME[1]
