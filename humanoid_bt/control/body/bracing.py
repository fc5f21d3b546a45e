"""How the body braces against what its palms press on."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np

from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.core.messages import Array, HandTarget, Side, Target

_TIME = 0.2  # s in which it comes to lean as far as it has to


class Bracing:
    """What pushes the palms that press, as a shift of the pressure under the feet that bears it.

    A force F at the height h needs the centre of mass F h / (m g) further ahead than the centre of pressure. Both move,
    by half of that each: the feet then bear what is pressed on becoming harder, and its giving way.

    Args:
        mass: of the robot [kg].
        dynamics: as it is estimated.
        dt: control period [s].

    Attributes:
        lean: how far the centre of mass has to be ahead of the centre of pressure, shape (2,), world frame [m].
    """

    def __init__(self, mass: float, dynamics: RobotDynamics, dt: float) -> None:
        self._weight, self._dynamics, self._sides = mass * GRAVITY, dynamics, tuple(dynamics.hands)
        self._share = min(1.0, dt / _TIME)
        self.reset()

    def reset(self) -> None:
        """Stand upright."""
        self.lean: Array = np.zeros(2)
        self._leans = False  # or has leaned: then it goes on for ever, by less and less

    def update(
        self,
        targets: Mapping[str, Target],
        forces: Mapping[str, Array],
        yielding: Collection[Side],
        place: Array,
        ground: float,
    ) -> None:
        """Lean against what pushes the palms that are to press.

        Args:
            targets: resource -> target.
            forces: group of links -> with which force it is pushed, world frame, shape (3,) [N].
            yielding: arms that follow what pushes them.
            place: middle between the feet, world frame, shape (2,) [m].
            ground: its height [m].
        """
        pressing = []
        for side in self._sides:
            target = targets.get(f"{side}_hand")
            if isinstance(target, HandTarget) and target.press and side not in yielding:
                pressing.append(side)
        if not (pressing or self._leans):
            return
        self._leans = True
        moment: Array = np.zeros(2)
        for side in pressing:
            palm, force = self._dynamics.palm(side), forces[f"{side}_arm"]
            moment += (palm[:2] - place) * force[2] - (palm[2] - ground) * force[:2]
        self.lean = self.lean + self._share * (moment / self._weight - self.lean)
