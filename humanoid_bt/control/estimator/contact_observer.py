"""What touches arms and torso, from the torques of their drives: the generalised momentum observer."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

import mujoco
import numpy as np

from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import SIDES, TORSO, Array, Side
from humanoid_bt.robot.model import BASE_DOFS, RobotModel, carriers, palm_site

_GAIN = 50.0  # 1/s, of the observer: three quarters of a force that begins are seen after 28 ms
_SINGULAR = 1e-3  # m^2, of a stretched arm, whose joints say little of forces along it
_LEARN_TIME = 1.5  # s, in which it is learnt what a hand carries
_MOST_CARRIED = 6.0  # kg


class ContactObserver:
    """The forces on palms and torso that explain best what the drives' torques do not move.

    The observer follows the generalised momentum p = M v of the robot (De Luca et al. 2006; Haddadin, De Luca,
    Albu-Schaeffer 2017): its residual r = K (p - integral of (tau + C^T v - g - d v + r)) is what else pushes its
    joints, through a low-pass of K. With the difference quotient of M over a control period in the place of
    dM/dt = C + C^T, the derivative of the integrand is tau - M dv/dt - h - d v, which is what is summed up here.

    The base moves, on legs whose contact forces are not known well. Therefore only the rows of arms and waist count,
    which these forces do not enter, and the base's acceleration is the IMU's.

    A force is told as if it were at the palm, or at the centre of mass of the torso: one at the elbow seems half as
    large. What a hand carries is learnt slowly from its weight, as a point of mass at the palm; neither its weight nor
    its inertia are contact then.

    Args:
        robot: the robot.
        dynamics: as it is estimated.

    Attributes:
        forces: group of links -> with which force it is pushed, world frame, shape (3,) [N].
        residual: of all degrees of freedom, shape (nv,) [N, Nm].
    """

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics) -> None:
        model, config = robot.model, robot.config
        self._dynamics, self._damping = dynamics, robot.model.dof_damping.copy()
        self._torso = model.body(config.torso).id
        self._palms: dict[Side, int] = {side: model.site(palm_site(side)).id for side in SIDES if side in config.hands}
        trunk = carriers(model, self._torso)
        arms = [carriers(model, model.body(config.hands[side].body).id) for side in self._palms]
        self._dofs = _dofs(model, {body for bodies in (trunk, *arms) for body in bodies})
        self._has_waist = bool(_dofs(model, trunk))
        groups = [f"{side}_arm" for side in self._palms] + [TORSO] * self._has_waist
        size = 3 * len(groups)
        self._jacobian = np.zeros((size, model.nv))
        self._before = np.zeros((size, model.nv))
        self._regular = _SINGULAR * np.eye(size)
        self._force: Array = np.zeros(size)
        self._carried: Array = np.zeros(len(groups))  # kg
        self.residual: Array = np.zeros(model.nv)
        self.forces: dict[str, Array] = {group: self._force[3 * at : 3 * at + 3] for at, group in enumerate(groups)}
        self._learns: Array = np.ones(len(groups))

    def reset(self) -> None:
        """Begin with a robot that nothing touches."""
        self._carried[:] = 0.0
        self._learns[:] = 1.0
        self.forget()

    def forget(self) -> None:
        """Take it that nothing touches the robot: what the sensors say is not to be relied on."""
        self.residual[:] = 0.0
        self._force[:] = 0.0
        self._look()

    def distrust(self, touched: Collection[str]) -> None:
        """Be told which groups of links touch something: what pushes them is nothing that they carry."""
        self._learns[:] = [group not in touched for group in self.forces]

    def update(self, acceleration: Array, torque: Array, time: float) -> None:
        """Take what happened since the last time.

        Args:
            acceleration: on average, shape (nv,).
            torque: of the joints, on average, shape (nj,) [Nm].
            time: [s].
        """
        dynamics, residual = self._dynamics, self.residual
        pushed = dynamics.inertia_times(acceleration)
        pushed += dynamics.bias
        pushed += self._damping * dynamics.data.qvel
        pushed[BASE_DOFS:] -= torque
        pushed += self._pull_of_carried(acceleration, time)
        pushed -= residual
        pushed *= -math.expm1(-_GAIN * time)
        residual += pushed
        if not self.forces:
            return
        jacobian = self._jacobian[:, self._dofs]
        moved = jacobian @ jacobian.T + self._regular
        mujoco.mju_cholFactor(moved, 0.0)
        mujoco.mju_cholSolve(self._force, moved, jacobian @ residual[self._dofs])
        self._learn(time)

    def _pull_of_carried(self, acceleration: Array, time: float) -> Array:
        """Return what it takes to hold and to move what is carried, shape (nv,) [N, Nm]."""
        self._before, self._jacobian = self._jacobian, self._before
        self._look()
        moved = self._jacobian @ acceleration
        moved += (self._jacobian - self._before) @ self._dynamics.data.qvel / time
        moved[2::3] += GRAVITY
        return np.asarray((np.repeat(self._carried, 3) * moved) @ self._jacobian)

    def torques_of_carried(self, side: Side) -> Array:
        """Return the torques, shape (nj,), with which the joints hold what a hand carries [Nm]."""
        place = list(self._palms).index(side)
        return np.asarray(GRAVITY * self._carried[place] * self._jacobian[3 * place + 2, BASE_DOFS:])

    def _look(self) -> None:
        """Find the Jacobians of palms and torso."""
        model, data, row = self._dynamics.model, self._dynamics.data, 0
        for site in self._palms.values():
            mujoco.mj_jacSite(model, data, self._jacobian[row : row + 3], None, site)
            row += 3
        if self._has_waist:
            mujoco.mj_jacBodyCom(model, data, self._jacobian[row:], None, self._torso)

    def _learn(self, time: float) -> None:
        """Learn what weighs on hands and torso."""
        learnt = self._carried - self._force[2::3] * (self._learns * (time / (_LEARN_TIME * GRAVITY)))
        clamp(learnt, -_MOST_CARRIED, _MOST_CARRIED, self._carried)


def _dofs(model: mujoco.MjModel, bodies: Iterable[int]) -> slice | list[int]:
    """Return the degrees of freedom of some bodies without the base; a slice if they come one after the other."""
    found = sorted(
        dof
        for body in bodies
        for dof in range(model.body_dofadr[body], model.body_dofadr[body] + model.body_dofnum[body])
        if dof >= BASE_DOFS
    )
    return slice(found[0], found[-1] + 1) if found and found == list(range(found[0], found[-1] + 1)) else found
