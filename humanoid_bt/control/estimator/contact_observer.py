"""What touches arms and torso, from the torques of their drives: the generalised momentum observer."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.control.estimator.small_matrices import factored, solved
from humanoid_bt.control.jacobians import Indices, chains, point_moves
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.compiled import compiled, inlined
from humanoid_bt.core.messages import SIDES, TORSO, Array, Side
from humanoid_bt.robot.model import BASE_DOFS, RobotModel, palm_site
from humanoid_bt.robot.mujoco_functions import mul_m

_GAIN = 50.0  # 1/s, of the observer: three quarters of a force that begins are seen after 28 ms
_SINGULAR = 1e-3  # m^2, of a stretched arm, whose joints say little of forces along it
_LEARN_TIMES = 0.1, 1.5  # s, in which it is learnt what a hand carries: as it begins, when nothing is known; later
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
    large. What a hand carries is learnt from its weight, as a point of mass at the palm; neither its weight nor its
    inertia are contact then. It is learnt slowly, for what begins to press on a hand may be contact; but what the hand
    has to begin with is learnt at once.

    Args:
        robot: the robot.
        dynamics: as it is estimated.

    Attributes:
        forces: group of links -> with which force it is pushed, world frame, shape (3,) [N].
        residual: of all degrees of freedom, shape (nv,) [N, Nm].
    """

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics) -> None:
        model, config = robot.model, robot.config
        self._damping = robot.model.dof_damping.copy()
        torso = model.body(config.torso).id
        self._palms: dict[Side, int] = {side: model.site(palm_site(side)).id for side in SIDES if side in config.hands}
        arms = [model.body(config.hands[side].body).id for side in self._palms]
        links = chains(model, [*arms, torso])
        has_waist = bool((links[-1] >= BASE_DOFS).any())
        self._links = links[: len(arms) + has_waist].copy()
        groups = [f"{side}_arm" for side in self._palms] + [TORSO] * has_waist
        data = dynamics.data
        palms = np.array(list(self._palms.values()), dtype=np.int64)
        self._places = dynamics.motions, dynamics.origin, data.site_xpos, palms, data.xipos[torso], self._links
        size = 3 * len(groups)
        self._jacobian = np.zeros((size, model.nv))
        self._force: Array = np.zeros(size)
        self._carried: Array = np.zeros(len(groups))  # kg
        self._learn_time = _LEARN_TIMES[0]
        self.residual: Array = np.zeros(model.nv)
        self.forces: dict[str, Array] = {group: self._force[3 * at : 3 * at + 3] for at, group in enumerate(groups)}
        self._learns: Array = np.ones(len(groups))
        self._observe = _observe.bind(
            self._jacobian, np.zeros_like(self._jacobian), *dynamics.addresses, self.residual, self._force,
            self._carried, self._learns, dynamics.bias, self._damping, data.qvel, *self._places,
            np.zeros(model.nv), np.zeros((size, size)),
        )  # fmt: skip

    def reset(self) -> None:
        """Begin with a robot that nothing touches."""
        self._carried[:] = 0.0
        self._learns[:] = 1.0
        self._learn_time = _LEARN_TIMES[0]
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
        self._learn_time = min(self._learn_time + time, _LEARN_TIMES[1])  # an average, at first
        self._observe(acceleration, torque, time, self._learn_time)

    def torques_of_carried(self, side: Side) -> Array:
        """Return the torques, shape (nj,), with which the joints hold what a hand carries [Nm]."""
        place = list(self._palms).index(side)
        return np.asarray(GRAVITY * self._carried[place] * self._jacobian[3 * place + 2, BASE_DOFS:])

    def _look(self) -> None:
        """Find the Jacobians of palms and torso."""
        _look(*self._places, self._jacobian)


@compiled("void(f8[:, ::1], f8[::1], f8[:, ::1], i8[::1], f8[::1], i8[:, ::1], f8[:, ::1])")
def _look(
    motions: Array, origin: Array, sites: Array, palms: Indices, torso: Array, links: Indices, jacobian: Array
) -> None:
    """Write how palms and torso move, three rows for each.

    Args:
        motions, origin: of the dynamics.
        sites, palms: positions of all sites, shape (n, 3) [m], and which of them are palms.
        torso: its centre of mass, shape (3,) [m].
        links: the degrees of freedom that move each palm, and then those that move the torso if there are any.
        jacobian: shape (3 len(links), nv).
    """
    for group in range(len(links)):
        point = sites[palms[group]] if group < len(palms) else torso
        point_moves(motions, origin, point, links[group], jacobian[3 * group : 3 * group + 3])


@inlined
def _hold(
    carried: Array,
    jacobian: Array,
    before: Array,
    links: Indices,
    acceleration: Array,
    velocity: Array,
    time: float,
    pushed: Array,
) -> None:
    """Add what it takes to hold and to move what is carried to what pushes the joints; see :func:`_observe`."""
    for row in range(len(jacobian)):
        total = GRAVITY if row % 3 == 2 else 0.0
        for dof in links[row // 3]:
            if dof < 0:
                break
            total += jacobian[row, dof] * acceleration[dof]
            total += (jacobian[row, dof] - before[row, dof]) * velocity[dof] / time
        for dof in links[row // 3]:
            if dof < 0:
                break
            pushed[dof] += carried[row // 3] * total * jacobian[row, dof]


@inlined
def _weigh(jacobian: Array, residual: Array, links: Indices, base: int, force: Array, square: Array) -> None:
    """Write J r and J J^T, made regular, of the joints: what is solved for the forces; see :func:`_observe`."""
    for row in range(len(jacobian)):
        force[row] = 0.0
        for column in range(row):
            square[row, column] = 0.0
        square[row, row] = _SINGULAR
        for dof in links[row // 3]:  # others do not move this point
            if dof < 0:
                break
            if dof < base:
                continue
            moves = jacobian[row, dof]
            force[row] += moves * residual[dof]
            for column in range(row + 1):
                square[row, column] += moves * jacobian[column, dof]


@bindable(
    "void(f8[::1], f8[::1], f8, f8)",
    "f8[:, ::1], f8[:, ::1], i8, i8, f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1],"
    " f8[:, ::1], f8[::1], f8[:, ::1], i8[::1], f8[::1], i8[:, ::1], f8[::1], f8[:, ::1]",
)
def _observe(
    acceleration: Array,
    torque: Array,
    time: float,
    learn_time: float,
    jacobian: Array,
    before: Array,
    model: int,
    data: int,
    residual: Array,
    force: Array,
    carried: Array,
    learns: Array,
    bias: Array,
    damping: Array,
    velocity: Array,
    motions: Array,
    origin: Array,
    sites: Array,
    palms: Indices,
    torso: Array,
    links: Indices,
    pushed: Array,
    square: Array,
) -> None:
    """See :meth:`ContactObserver.update`.

    Args:
        acceleration, torque, time: as there.
        learn_time: in which it is learnt what is carried [s].
        jacobian, before: of the points, now and the time before; are written.
        model, data: addresses of MuJoCo's.
        residual, force, carried: are brought up to date.
        learns: 1 for groups of which it is learnt what they carry, 0 for others.
        bias, damping, velocity: of the dynamics.
        motions, origin, sites, palms, torso, links: as :func:`_look` wants them.
        pushed, square: are written.
    """
    before[:] = jacobian
    _look(motions, origin, sites, palms, torso, links, jacobian)
    size, base = len(force), len(residual) - len(torque)
    mul_m(model, data, pushed.ctypes, acceleration.ctypes)
    for dof in range(len(residual)):
        pushed[dof] = pushed[dof] + bias[dof] + damping[dof] * velocity[dof] - residual[dof]
    for joint in range(len(torque)):
        pushed[base + joint] -= torque[joint]
    _hold(carried, jacobian, before, links, acceleration, velocity, time, pushed)
    gain = -math.expm1(-_GAIN * time)
    for dof in range(len(residual)):
        residual[dof] += gain * pushed[dof]
    _weigh(jacobian, residual, links, base, force, square)
    factored(square, size)
    solved(square, force)
    for group in range(len(carried)):  # learn what weighs on hands and torso
        learnt = carried[group] - force[3 * group + 2] * learns[group] * (time / (learn_time * GRAVITY))
        carried[group] = min(max(learnt, -_MOST_CARRIED), _MOST_CARRIED)
