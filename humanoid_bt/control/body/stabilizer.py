"""Balance: DCM feedback to a zero-moment point, shared between the feet, and the reference of the centre of mass."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from humanoid_bt.control.body.support import shared
from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.config import GaitConfig, SoleConfig


@dataclass(frozen=True)
class Load:
    """How the feet carry the robot. Its arrays stay, and are written anew in every control period.

    Attributes:
        share: of the weight, of the (left, right) foot, in [0, 1], shape (2,).
        cop: their centres of pressure, shape (2, 2), world frame [m].
        zmp: the resulting zero-moment point, shape (2,), world frame [m].
        force: the resulting ground force on the robot, shape (3,), world frame [N].
    """

    share: Array
    cop: Array
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
        self._half = np.array(sole.bears)
        self._load = Load(np.zeros(2), np.zeros((2, 2)), np.zeros(2), np.zeros(3))
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
        lean: Array,
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
            lean: how far the centre of mass has to be ahead of the centre of pressure besides, likewise: each of the
                references gives way by half of it.
            momentum_rate: of the angular momentum about the centre of mass of the planned motion, shape (3,) [Nm].
            soles: measured poses, shape (3,).
            contact: whether each foot is on the ground.
        """
        gait, load = self._gait, self._load
        _balance(
            load.share, load.cop, load.zmp, load.force, self.com_reference, com, dcm, dcm_reference, zmp_reference,
            lean, momentum_rate, soles["left"], soles["right"], contact["left"], contact["right"], self._half,
            gait.momentum_limit, gait.dcm_gain, gait.com_slide, self._mass, self.omega, self._dt,
        )  # fmt: skip
        return load


@compiled(
    "void(f8[::1], f8[:, ::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1],"
    " f8[::1], f8[::1], f8[::1], b1, b1, f8[::1], f8, f8, f8, f8, f8, f8)"
)
def _balance(
    share: Array,
    cop: Array,
    zmp: Array,
    force: Array,
    reference: Array,
    com: Array,
    dcm: Array,
    dcm_reference: Array,
    zmp_reference: Array,
    lean: Array,
    momentum_rate: Array,
    left: Array,
    right: Array,
    left_stands: bool,
    right_stands: bool,
    half: Array,
    most: float,
    gain: float,
    slide: float,
    mass: float,
    omega: float,
    dt: float,
) -> None:
    """See :meth:`Stabilizer.update`.

    Args:
        share, cop, zmp, force: are written, as in :class:`Load`, shapes (2,), (2, 2), (2,), (3,).
        reference: of the centre of mass, shape (2,); is moved.
        com, dcm, dcm_reference, zmp_reference, lean, momentum_rate: as there.
        left, right, left_stands, right_stands: the soles, and whether they are on the ground.
        half: of the part of a sole that may bear pressure, shape (2,) [m].
        most, gain, slide: of the robot's gait.
        mass, omega, dt: [kg], [1/s], [s].
    """
    weight = mass * GRAVITY
    shift_x = min(max(-momentum_rate[1] / weight, -most), most)
    shift_y = min(max(momentum_rate[0] / weight, -most), most)
    dcm_x, dcm_y = dcm_reference[0] + lean[0] / 2, dcm_reference[1] + lean[1] / 2
    x = (zmp_reference[0] - lean[0] / 2) + gain * (dcm[0] - dcm_x) + shift_x
    y = (zmp_reference[1] - lean[1] / 2) + gain * (dcm[1] - dcm_y) + shift_y
    on_right = shared(x, y, left, right, left_stands, right_stands, half, cop)
    share[0], share[1] = 1.0 - on_right, on_right
    for axis in range(2):
        zmp[axis] = share[0] * cop[0, axis] + share[1] * cop[1, axis]
        shift, wanted = (shift_x, dcm_x) if axis == 0 else (shift_y, dcm_y)
        force[axis] = mass * omega**2 * (com[axis] - (zmp[axis] - shift))
        reference[axis] += dt * (omega * (wanted - reference[axis]) + slide * (com[axis] - reference[axis]))
    force[2] = weight
