"""How much the feet carry, from sensors in them or, where there are none, from the torques of the legs."""

from __future__ import annotations

import numpy as np

from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.control.jacobians import Indices, chains, point_moves
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.robot.model import BASE_DOFS, RobotModel, sole_site
from humanoid_bt.robot.mujoco_functions import mul_m

_LOADED, _UNLOADED = 0.15, 0.08  # share of the weight from and up to which a foot stands (hysteresis)
_SINGULAR = 1e-4  # m^2, of a stretched leg, which says little of forces along it
_PULLS = 0.1  # share of the weight with which a leg must seem to pull for that
_CARRIED = 0.5  # share of the weight from which something must carry it
_JOINTS_OFF, _WHOLE_OFF = 3.0, 40.0  # Nm and N, by how much torques of joints and the whole load are off, usually


class FootLoad:
    """The normal forces on the feet.

    Without sensors in the feet, the force f at each sole is the one that explains best, in the sense of least squares,
    what the joints of its leg do: J^T f = M qdd + h + d qd - tau. A stretched leg says little of the force along it.
    What carries the robot altogether is known as well, by how the base accelerates. Where that is its weight, and no
    leg says that it carries any but one that it pulls at the ground, which no foot can, what is missing is given to
    each in proportion to how uncertain its force is. Where none pulls, people may hold the robot.

    Args:
        robot: the robot.
        dynamics: as it is estimated.

    Attributes:
        force: on the (left, right) foot, shape (2,) [N].
        standing: whether each carries something.
    """

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics) -> None:
        self._dynamics = dynamics
        self._weight = robot.mass * GRAVITY
        self.force: Array = np.zeros(2)
        self.standing = [True, True]
        soles = np.array([robot.model.site(sole_site(side)).id for side in SIDES])
        self._explain = _explain.bind(
            robot.mass, *dynamics.addresses, self.force, dynamics.bias, robot.model.dof_damping.copy(),
            dynamics.motions, dynamics.origin, dynamics.data.site_xpos, soles, _legs(robot),
            np.zeros(robot.model.nv), np.zeros((3, robot.model.nv)), np.zeros(2),
        )  # fmt: skip

    def reset(self) -> None:
        """Begin with a robot that stands on both feet."""
        self.force[:] = self._weight / 2
        self.standing = [True, True]

    def sensed(self, force: Array) -> None:
        """Take what sensors in the feet say, shape (2,) [N]."""
        self.force[:] = force
        self._judge()

    def explain(self, velocity: Array, acceleration: Array, torque: Array, rises: float) -> None:
        """Find the forces that explain a motion.

        Args:
            velocity, acceleration: shape (nv,).
            torque: of the joints, shape (nj,) [Nm].
            rises: how the base accelerates upward by its accelerometer [m/s^2].
        """
        self._explain(velocity, acceleration, torque, rises)
        self._judge()

    def _judge(self) -> None:
        (left, right), (left_stands, right_stands) = self.force.tolist(), self.standing
        loaded, unloaded = _LOADED * self._weight, _UNLOADED * self._weight
        self.standing[0] = left > (unloaded if left_stands else loaded)
        self.standing[1] = right > (unloaded if right_stands else loaded)


@bindable(
    "void(f8[::1], f8[::1], f8[::1], f8)",
    "f8, i8, i8, f8[::1], f8[::1], f8[::1],"
    " f8[:, ::1], f8[::1], f8[:, ::1], i8[::1], i8[:, ::1], f8[::1], f8[:, ::1], f8[::1]",
)
def _explain(
    velocity: Array,
    acceleration: Array,
    torque: Array,
    rises: float,
    mass: float,
    model: int,
    data: int,
    force: Array,
    bias: Array,
    damping: Array,
    motions: Array,
    origin: Array,
    places: Array,
    sites: Indices,
    legs: Indices,
    left: Array,
    jacobian: Array,
    doubts: Array,
) -> None:
    """Write the vertical part of the force f on each foot that minimises |J^T f - (M qdd + h + d qd - tau)|.

    Args:
        velocity, acceleration, torque: qd, qdd, and of the joints tau.
        rises: acceleration of the base upward.
        mass: of the robot.
        model, data: addresses of MuJoCo's.
        force: is written, shape (2,) [N].
        bias, damping: h, d.
        motions, origin: of the dynamics.
        places, sites: of all sites, and which of them are the soles.
        legs: the degrees of freedom of each leg.
        left, jacobian, doubts: are written; the last are the variances of both forces.
    """
    base = len(left) - len(torque)
    mul_m(model, data, left.ctypes, acceleration.ctypes)
    for dof in range(len(left)):
        left[dof] = left[dof] + bias[dof] + damping[dof] * velocity[dof]
    for joint in range(len(torque)):
        left[base + joint] -= torque[joint]
    whole = left[2] + mass * (rises - acceleration[2])
    for foot in range(2):
        point_moves(motions, origin, places[sites[foot]], legs[foot], jacobian)
        a = d = f = _SINGULAR  # of A = J J^T, made regular
        b = c = e = 0.0
        x = y = z = 0.0  # of J (...)
        for dof in legs[foot]:
            if dof < 0:
                break
            u, v, w = jacobian[0, dof], jacobian[1, dof], jacobian[2, dof]
            a, b, c, d, e, f = a + u * u, b + u * v, c + u * w, d + v * v, e + v * w, f + w * w
            x, y, z = x + u * left[dof], y + v * left[dof], z + w * left[dof]
        minor, first, second = a * d - b * b, b * e - c * d, b * c - a * e  # by Cramer's rule
        determinant = minor * f + second * e + first * c
        force[foot] = (minor * z + second * y + first * x) / determinant
        doubts[foot] = _JOINTS_OFF**2 * minor / determinant
    weight = mass * GRAVITY
    pulls = min(force[0], force[1]) < -_PULLS * weight
    if pulls and max(force[0], force[1]) < _LOADED * weight and whole > _CARRIED * weight:
        missing = (whole - force[0] - force[1]) / (_WHOLE_OFF**2 + doubts[0] + doubts[1])
        force[0] += doubts[0] * missing
        force[1] += doubts[1] * missing


def _legs(robot: RobotModel) -> Indices:
    """Return the joints between the base and each foot.

    Those that both feet have, of a waist below the base, say nothing of one of them: they carry the other one as well.
    """
    both = chains(robot.model, [robot.model.body(robot.config.legs[side].sole.body).id for side in SIDES])
    for leg, other in ((both[0], both[1].copy()), (both[1], both[0].copy())):
        own = [dof for dof in leg if dof >= BASE_DOFS and dof not in other]
        leg[:] = -1
        leg[: len(own)] = own
    return both
