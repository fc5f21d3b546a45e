"""How high the ground is under each foot, seen from the ground that the robot stands on."""

from __future__ import annotations

import math
from collections.abc import Sequence

from humanoid_bt.core.messages import Array

_EVEN = 0.006  # m between two feet up to which the ground counts as level
_SETTLE_TIME = 1.0  # s in which heights are counted from a foot that has landed higher or lower


class Ground:
    """The height of the ground under each foot, taken when the foot lands.

    The robot has no map: heights are counted from where it stands, so that the mean of its standing feet is 0 again
    soon, on a slope and on stairs, too.

    Attributes:
        heights: under the (left, right) foot [m].
    """

    def __init__(self) -> None:
        self.heights = [0.0, 0.0]
        self._stood = [True, True]

    def reset(self, feet: Array) -> None:
        """Begin on both feet; ``feet`` are their heights, shape (2,) [m]."""
        left, right = feet.tolist()
        self.heights = [0.0, 0.0] if abs(left - right) < _EVEN else [left, right]
        self._stood = [True, True]

    def land(self, feet: Array, standing: Sequence[bool]) -> None:
        """Take the height of the ground under each foot that has come to stand on it.

        Args:
            feet: heights of the (left, right) sole as they are estimated, shape (2,) [m].
            standing: whether each is on the ground.
        """
        heights, stood = self.heights, self._stood
        if standing == stood:
            return
        for foot, stands in enumerate(standing):
            if stands and not stood[foot]:
                other, height = heights[1 - foot], feet.item(foot)
                heights[foot] = other if abs(height - other) < _EVEN else height
            stood[foot] = stands

    def sink(self, time: float) -> float:
        """Return by how much everything sinks in a time [s], seen from the ground that the robot stands on now [m]."""
        (left, right), stood = self.heights, self._stood
        if left == right == 0 or not any(stood):
            return 0.0
        mean = (left + right) / 2 if all(stood) else left if stood[0] else right
        sinks = mean * (1 - math.exp(-time / _SETTLE_TIME))
        self.heights = [left - sinks, right - sinks]
        return sinks
