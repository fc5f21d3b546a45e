"""A limit of the whole-body inverse kinematics: how low the base may go."""

from __future__ import annotations

import mink
import numpy as np

from humanoid_bt.core.messages import Array

_HEIGHT = 2  # coordinate, and degree of freedom, of the free base's height
_BRAKE_TIME = 0.1  # s in which a sinking base comes to rest above the limit


class HeightLimit(mink.Limit):  # type: ignore[misc]  # mink has no types
    """Keeps the base above a height: a hand that pulls it lower would make a crouch look like a fall.

    A base that is lower already may rise, and does not have to: standing still is always allowed.

    Args:
        nv: degrees of freedom of the model.

    Attributes:
        lowest: of the base [m].
    """

    def __init__(self, nv: int) -> None:
        self.lowest = 0.0
        self._down: Array = np.zeros((1, nv))
        self._down[0, _HEIGHT] = -1.0

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        """Return how far the base may sink in ``dt``."""
        room = max(0.0, float(configuration.data.qpos[_HEIGHT]) - self.lowest)
        return mink.Constraint(G=self._down, h=np.array([room * min(1.0, dt / _BRAKE_TIME)]))
