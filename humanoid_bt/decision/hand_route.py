"""The way of a palm over what is solid: up before it, across above it, and down at the end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.core.texts import listed
from humanoid_bt.decision.arguments import side_of
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.perception.track import Track

_ASIDE = 0.12  # m that a palm keeps beside a box: as long as fingers are
_ABOVE = 0.08  # m that it keeps above one
_HIGH = 0.13  # m above a box at which it goes across
_DOWN = 0.12  # m from where it is to go, seen from above, within which it may come down
_BEFORE = (0.22, 0.22)  # m ahead and to its side where a palm goes up
_BACK = (0.12, 0.28)  # m ahead and to its side to which it is drawn back when it is below something
_FARTHEST = 1.5  # m from the robot from which on a box is in no hand's way


class HandRoute:
    """A way of a palm over everything solid that the robot has seen; ask for the next place in every tick.

    Args:
        robot: the skill's ``self.robot``.

    Attributes:
        blocked: what is between the palm and its goal, as of the last :meth:`next`, for people; "" if nothing is.
    """

    def __init__(self, robot: RobotHandle) -> None:
        self._robot = robot
        self.blocked, self._verb = "", "is"

    def next(self, side: Side, goal: Any, ignore: Sequence[str] = ()) -> Array:
        """Return where to send a palm now, shape (3,), world frame [m]: to its goal if nothing is between.

        Args:
            side: of the hand.
            goal: where it is to get, shape (3,), world frame [m].
            ignore: obstacles that it may come to, such as the one that it reaches for.

        Raises:
            HumanoidBtError: the robot has no such hand.
            ValueError: there is no such side.
        """
        palm = self._robot.state.hands.get(side_of(side))
        if palm is None:
            raise HumanoidBtError(f"the robot has no {side} hand")
        end = np.array(goal, dtype=float)
        here = self._robot.state.stance[:2]
        boxes = [
            box
            for box in self._robot.obstacles
            if box.name not in ignore and math.dist(box.position_world[:2], here) < _FARTHEST + _radius(box)
        ]
        met = [box for box in boxes if _hits(box, palm, end, _DOWN)]
        if not met:
            self.blocked = ""
            return end
        self.blocked, self._verb = listed([box.name for box in met]), "is" if len(met) == 1 else "are"
        height = max(_top(box) for box in met) + _HIGH
        above, before = np.array([*end[:2], max(height, end[2])]), self._beside(side, _BEFORE, height)
        for place in (above, before):
            if not any(_hits(box, palm, place) for box in boxes):
                return place
        return self._beside(side, _BACK, float(palm[2]))

    def why_no_nearer(self, side: Side, distance: float) -> str:
        """Say that a palm comes no nearer to its goal than this [m], and what is in the way.

        ``left hand comes no nearer than 12 cm: table is in the way``
        """
        why = self._robot.why_no_nearer(side, distance)
        known = self._robot.touched(side) or side in self._robot.state.hand_obstacles
        return why if known or not self.blocked else f"{why}: {self.blocked} {self._verb} in the way"

    def _beside(self, side: Side, where: tuple[float, float], height: float) -> Array:
        """Return a place before the robot, on the side of a hand, shape (3,), world frame."""
        x, y, heading = self._robot.state.stance.tolist()
        ahead, aside = where[0], where[1] if side == "left" else -where[1]
        cos, sin = math.cos(heading), math.sin(heading)
        return np.array([x + cos * ahead - sin * aside, y + sin * ahead + cos * aside, height])


def _hits(box: Track, start: Array, end: Array, down: float = 0.0) -> bool:
    """Return whether a straight way comes too near to a box, but for its last piece, so long seen from above [m]."""
    assert box.size is not None
    cos, sin = math.cos(box.heading_world), math.sin(box.heading_world)
    turn = np.array([[cos, sin], [-sin, cos]])
    begin, way = turn @ (start - box.position_world)[:2], turn @ (end - start)[:2]
    half = box.size[:2] / 2 + _ASIDE
    enters, leaves = 0.0, 1.0 - min(1.0, down / max(float(np.linalg.norm(way)), 1e-9))
    for place, step, most in zip(begin.tolist(), way.tolist(), half.tolist(), strict=True):
        if abs(step) < 1e-9:
            if abs(place) >= most:
                return False
            continue
        sides = sorted(((-most - place) / step, (most - place) / step))
        enters, leaves = max(enters, sides[0]), min(leaves, sides[1])
    if enters >= leaves:
        return False
    heights = [float(start[2] + share * (end[2] - start[2])) for share in (enters, leaves)]
    bottom = float(box.position_world[2] - box.size[2] / 2)
    return min(heights) < _top(box) + _ABOVE and max(heights) > bottom - _ABOVE


def _top(box: Track) -> float:
    assert box.size is not None
    return float(box.position_world[2] + box.size[2] / 2)


def _radius(box: Track) -> float:
    assert box.size is not None
    return float(np.linalg.norm(box.size[:2])) / 2
