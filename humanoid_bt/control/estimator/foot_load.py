"""How much the feet carry, from sensors in them or, where there are none, from the torques of the legs."""

from __future__ import annotations

import mujoco
import numpy as np

from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.robot.model import BASE_DOFS, RobotModel, carriers, sole_site

_LOADED, _UNLOADED = 0.15, 0.08  # share of the weight from and up to which a foot stands (hysteresis)
_SINGULAR = 1e-4  # m^2, of a stretched leg, which says little of forces along it


class FootLoad:
    """The normal forces on the feet.

    Without sensors in the feet, the force f at each sole is the one that explains best, in the sense of least squares,
    what the joints of its leg do: J^T f = M qdd + h + d qd - tau.

    Args:
        robot: the robot.
        dynamics: as it is estimated.

    Attributes:
        force: on the (left, right) foot, shape (2,) [N].
        standing: whether each carries something.
    """

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics) -> None:
        self._dynamics = dynamics
        self._sites = [robot.model.site(sole_site(side)).id for side in SIDES]
        left, right = (_carrying(robot, side) for side in SIDES)
        self._legs = [_indices(left - right), _indices(right - left)]
        self._damping = robot.model.dof_damping.copy()
        self._weight = robot.mass * GRAVITY
        self._jacobian = np.zeros((3, robot.model.nv))
        self.force: Array = np.zeros(2)
        self.standing = [True, True]

    def reset(self) -> None:
        """Begin with a robot that stands on both feet."""
        self.force[:] = self._weight / 2
        self.standing = [True, True]

    def sensed(self, force: Array) -> None:
        """Take what sensors in the feet say, shape (2,) [N]."""
        self.force[:] = force
        self._judge()

    def explain(self, velocity: Array, acceleration: Array, torque: Array) -> None:
        """Find the forces that explain a motion.

        Args:
            velocity, acceleration: shape (nv,).
            torque: of the joints, shape (nj,) [Nm].
        """
        dynamics = self._dynamics
        left = dynamics.bias + dynamics.inertia_times(acceleration) + self._damping * velocity
        left[BASE_DOFS:] -= torque
        model, data, whole = dynamics.model, dynamics.data, self._jacobian
        for foot, (site, leg) in enumerate(zip(self._sites, self._legs, strict=True)):
            mujoco.mj_jacSite(model, data, whole, None, site)
            jacobian = whole[:, leg]
            self.force[foot] = _vertical(jacobian.dot(jacobian.T), jacobian.dot(left[leg]))
        self._judge()

    def _judge(self) -> None:
        for foot, force in enumerate(self.force.tolist()):
            self.standing[foot] = force > (_UNLOADED if self.standing[foot] else _LOADED) * self._weight


def _vertical(moved: Array, explained: Array) -> float:
    """Return f_z of A f = b for a symmetric A, shape (3, 3), made regular, by Cramer's rule."""
    (a, b, c), (_, d, e), (_, _, f) = moved.tolist()
    x, y, z = explained.tolist()
    a, d, f = a + _SINGULAR, d + _SINGULAR, f + _SINGULAR
    minor, first, second = a * d - b * b, b * e - c * d, b * c - a * e
    return float((minor * z + second * y + first * x) / (minor * f + second * e + first * c))


def _carrying(robot: RobotModel, side: str) -> set[int]:
    """Return the degrees of freedom between the base and a foot.

    Those that both feet have, of a waist below the base, say nothing of one of them: they carry the other one as well.
    """
    model = robot.model
    foot = model.body(robot.config.legs[side].sole.body).id
    return {
        dof
        for body in carriers(model, foot)
        for dof in range(model.body_dofadr[body], model.body_dofadr[body] + model.body_dofnum[body])
        if dof >= BASE_DOFS
    }


def _indices(dofs: set[int]) -> slice | list[int]:
    """Return degrees of freedom as indices of arrays; a slice if they come one after the other."""
    first, behind = min(dofs), max(dofs) + 1
    return slice(first, behind) if len(dofs) == behind - first else sorted(dofs)
