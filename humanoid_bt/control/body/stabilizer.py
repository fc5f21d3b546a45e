"""Balance: DCM feedback to a zero-moment point, shared between the feet, and the reference of the centre of mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from humanoid_bt.control.body.support import shared
from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.messages import Array, Side
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
        self._half = sole.bears
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
        roll, pitch, _ = momentum_rate.tolist()
        most, weight = gait.momentum_limit, self._mass * GRAVITY
        shift = [min(max(-pitch / weight, -most), most), min(max(roll / weight, -most), most)]
        now, planned, stands_on = dcm.tolist(), dcm_reference.tolist(), zmp_reference.tolist()
        wanted = np.array([stands_on[i] + gait.dcm_gain * (now[i] - planned[i]) + shift[i] for i in (0, 1)])
        share, cop = shared(wanted, soles, contact, self._half)
        zmp = share["left"] * cop["left"] + share["right"] * cop["right"]
        stiffness = self._mass * self.omega**2
        x, y = (stiffness * (com.item(i) - (zmp.item(i) - shift[i])) for i in (0, 1))
        force = np.array([x, y, weight])
        reference = self.com_reference
        reference += dt * (self.omega * (dcm_reference - reference) + gait.com_slide * (com[:2] - reference))
        return Load(share, cop, zmp, force)
