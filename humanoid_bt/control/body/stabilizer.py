"""Balance: DCM feedback to a zero-moment point, shared between the feet, and the reference of the centre of mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from humanoid_bt.control.body.footsteps import OTHER
from humanoid_bt.control.body.planar import inside
from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig


@dataclass(frozen=True)
class Load:
    """How the feet carry the robot.

    Attributes:
        share: of the weight, per foot, in [0, 1].
        cop: centre of pressure per foot, shape (2,), world frame [m].
        zmp: the resulting zero-moment point, shape (2,), world frame [m].
        force: the resulting ground force on the robot, shape (3,), world frame [N].
    """

    share: Mapping[Side, float]
    cop: Mapping[Side, Array]
    zmp: Array
    force: Array


class Stabilizer:
    """Keeps the divergent component of motion on its plan.

    Args:
        gait, sole: the robot's numbers.
        mass: [kg].
        dt: control period [s].

    Attributes:
        com_reference: reference of the centre of mass, shape (2,), world frame [m].
        omega: sqrt(g / z_c) [1/s].
    """

    def __init__(self, gait: GaitConfig, sole: SoleConfig, mass: float, dt: float) -> None:
        self._gait, self._mass, self._dt = gait, mass, dt
        self._half = (sole.half_length - sole.margin, sole.half_width - sole.margin)
        self.com_reference: Array = np.zeros(2)
        self.omega = 1.0

    def reset(self, com: Array) -> None:
        """Start from a robot at rest with its centre of mass at ``com``, shape (3,), above the ground."""
        self.com_reference = com[:2].copy()
        self.omega = float(np.sqrt(GRAVITY / com[2]))

    def update(
        self,
        *,
        com: Array,
        dcm: Array,
        dcm_reference: Array,
        zmp_reference: Array,
        momentum_rate: Array,
        soles: Mapping[Side, Array],
        contact: Mapping[Side, bool],
    ) -> Load:
        """Return how the feet shall carry the robot now, and move the centre of mass' reference.

        p = p_ref + k (xi - xi_ref) + s, with s = (-L_dot_y, L_dot_x) / (m g) from the angular momentum that the
        planned motion itself has, and F = m [omega^2 (c - p + s), g]
        (Takenaka 2009; Englsberger, Ott, Albu-Schaeffer 2015).

        Args:
            com: measured, shape (3,) [m].
            dcm, dcm_reference, zmp_reference: shape (2,), world frame [m].
            momentum_rate: of the angular momentum about the centre of mass of the planned motion, shape (3,) [Nm].
            soles: measured poses, shape (3,).
            contact: whether each foot is on the ground.
        """
        gait, dt = self._gait, self._dt
        shift = np.array([-momentum_rate[1], momentum_rate[0]]) / (self._mass * GRAVITY)
        shift = clamp(shift, -gait.momentum_limit, gait.momentum_limit)
        wanted = zmp_reference + gait.dcm_gain * (dcm - dcm_reference) + shift
        share, cop = self._share(wanted, soles, contact)
        zmp = share["left"] * cop["left"] + share["right"] * cop["right"]
        acceleration = self.omega**2 * (com[:2] - (zmp - shift))
        force = self._mass * np.array([acceleration[0], acceleration[1], GRAVITY])
        reference = self.com_reference
        reference += dt * (self.omega * (dcm_reference - reference) + gait.com_slide * (com[:2] - reference))
        return Load(share, cop, zmp, force)

    def _share(
        self, wanted: Array, soles: Mapping[Side, Array], contact: Mapping[Side, bool]
    ) -> tuple[dict[Side, float], dict[Side, Array]]:
        for side in SIDES:
            if not contact[OTHER[side]]:
                cop = inside(soles[side], wanted, *self._half)
                return {side: 1.0, OTHER[side]: 0.0}, {side: cop, OTHER[side]: soles[OTHER[side]][:2]}
        left, right = soles["left"][:2], soles["right"][:2]
        line = right - left
        on_right = float(np.clip((wanted - left) @ line / (line @ line), 0.0, 1.0))
        offset = wanted - (left + on_right * line)
        cop_left = inside(soles["left"], left + offset, *self._half)
        cop_right = inside(soles["right"], right + offset, *self._half)
        return {"left": 1.0 - on_right, "right": on_right}, {"left": cop_left, "right": cop_right}
