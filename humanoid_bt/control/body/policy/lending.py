"""Which joints a learned walker lends now, and how they are handed over without a jump."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.control.body.references import approach
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.core.patterns import matches
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.robot.policy.policy import Indices, Policy

WAIST = "waist"
"""The joints that carry the trunk, on which the walker balances."""

VIEW = "view"
"""Those of the waist that turn and nod, for the view of a robot without a neck: a walker needs the roll to walk."""

_BACK_TIME, _WAIST_BACK_TIME = 0.5, 0.5  # s in which joints are given back to the walker
_ROLLS = 0.7  # of the part ahead of a joint's axis that leans the trunk aside
_AT_HOME = 0.05  # rad from the default pose within which they are given back


class Lending:
    """Groups of joints, each lent or not: ``left_hand``, ``right_hand``, ``gaze``, ``waist`` and ``view``.

    A group that is wanted is lent at once. When nobody wants it any more it first goes home, and is given back little
    by little there; the waist at once. Joints of the robot that the walker does not move are always lent: those of
    arms and neck to whoever wants them, others only to stay in the posture.

    Args:
        robot: the robot.
        policy: its walker.
        dt: control period [s].

    Attributes:
        groups: name -> joints of the robot, as indices.
        share: how far each joint of the robot is lent, shape (nj,), in [0, 1].
        limbs: likewise of all but the waist, on which the walker goes on to balance.
        busy: whether anything is lent that the walker could move itself.
        joints: those that are lent, at least a little.
        free: those of them that hands and gaze may move.
        kept: the others, which stay in the posture.
    """

    def __init__(self, robot: RobotModel, policy: Policy, dt: float) -> None:
        names, config, lend = robot.joint_names, robot.config, policy.config.lend
        moved = {policy.joints[index] for index in policy.moves}
        neck = [config.neck.yaw, config.neck.pitch] if config.neck else []
        parts = {f"{side}_hand": [names[joint] for joint in robot.arm_joints(side)] for side in SIDES}
        parts["gaze"] = neck
        self.groups: dict[str, list[int]] = {
            group: [
                names.index(name)
                for name in of
                if name not in moved or lend.joints is None or _matches(name, lend.joints)
            ]
            for group, of in parts.items()
        }
        self.groups[WAIST] = [index for index, name in enumerate(names) if _matches(name, lend.waist)]
        aside = rolls(robot.axes)
        self.groups[VIEW] = [joint for joint in self.groups[WAIST] if not aside[joint]]
        self._always = np.array([float(name not in moved) for name in names])
        self._always_free = np.zeros(len(names))
        for group in parts:
            self._always_free[self.groups[group]] = self._always[self.groups[group]]
        self._dt = dt
        self.reset()

    def reset(self) -> None:
        """Give everything back."""
        self._shares = dict.fromkeys(self.groups, 0.0)
        self._take(np.zeros(len(self._always)))

    def lends(self, group: str) -> bool:
        """Return whether any of a group is lent."""
        return self._shares[group] > 0

    def update(self, wanted: Mapping[str, bool], away: Array) -> list[int]:
        """Lend what is wanted, give back what is not; return the joints that were not, or no more, lent wholly.

        Args:
            wanted: group -> whether somebody wants it.
            away: how far each planned joint is from the default pose, shape (nj,) [rad].
        """
        shares = {group: self._shared(group, wanted.get(group, False), away) for group in self.groups}
        if shares == self._shares:
            return []
        self._shares = shares
        given = [joints for group, joints in self.groups.items() if wanted.get(group)]
        fresh = [joint for joints in given for joint in joints if self.share[joint] < 1]
        share = np.zeros(len(self._always))
        for group, joints in self.groups.items():
            share[joints] = np.maximum(share[joints], shares[group])
        self._take(share)
        return fresh

    def _shared(self, group: str, wanted: bool, away: Array) -> float:
        """Return how far a group is lent from now on."""
        before, joints = self._shares[group], self.groups[group]
        if wanted and joints:
            return 1.0
        at_once = group in (WAIST, VIEW)
        if before and (at_once or before < 1 or np.abs(away[joints]).max() < _AT_HOME):
            return approach(before, 0.0, self._dt / (_WAIST_BACK_TIME if at_once else _BACK_TIME))
        return before

    def _take(self, share: Array) -> None:
        """Take how far the groups lend each joint, shape (nj,)."""
        self.busy = any(self._shares.values())
        self.share: Array = np.maximum(share, self._always)
        self.limbs = self.share.copy()
        self.limbs[self.groups[WAIST]] = 0.0
        free = np.maximum(share, self._always_free)
        self.joints: Indices = np.flatnonzero(self.share)
        self.free: Indices = np.flatnonzero(free)
        self.kept: Indices = np.flatnonzero((self.share > 0) & (free == 0))


def rolls(axes: Array) -> NDArray[np.bool_]:
    """Return which joints lean the trunk aside, of their axes, shape (n, 3): shape (n,)."""
    return np.abs(axes[:, 0]) >= _ROLLS


def _matches(name: str, patterns: Iterable[str]) -> bool:
    return any(matches(name, pattern) for pattern in patterns)
