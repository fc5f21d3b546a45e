"""What the body always follows, as one task of mink's: the rows of one least-squares problem."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from humanoid_bt.control.body.rows_task import RowsTask
from humanoid_bt.control.jacobians import Indices, chains, link_turns, momenta, point_moves
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.compiled import inlined
from humanoid_bt.core.messages import SIDES, Array, HandTarget, Side
from humanoid_bt.core.turns import (
    Quaternion,
    Vector,
    between,
    leaning,
    of_matrix,
    of_vector,
    product,
    tilted,
    view_along,
)
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, GAZE_SITE, RobotModel, carriers, sole_site

_SOLES, _BASE, _TORSO, _GAZE = (3, 9), 15, 18, 21  # first rows, after those of the centre of mass; then the posture
_NO_TURN = 1e-14  # square of a turn too small to matter [rad^2]
_LEANS = 0.3  # rad of lean for the gaze at which a reaching hand does not turn the torso any more
_SWINGS = np.array([0.4, 0.4, 1.0, 0.3, 0.3, 0.3])  # factors of a foot's costs in the air: place, height, turn


@dataclass
class BodyTargets:
    """What the whole body shall do in this control period; world frame.

    Attributes:
        com: centre of mass, shape (3,) [m].
        soles: pose (x, y, yaw) of each sole.
        sole_footings: height of each sole, and its tilt about the world's x and y [m, rad].
        sole_corrections: shift of each sole [m], and turn about its place [rad], shape (6,).
        heading: of the pelvis [rad].
        torso_yaw: of the torso relative to the heading [rad].
        lean: of the pelvis and of the torso ahead [rad].
        tilt: of the pelvis and of the torso, besides, each about the x and y of the heading, which are level [rad].
        gaze: (yaw relative to the heading, pitch) of the view [rad].
        hands: palm positions, shape (3,) [m], of the hands that are commanded.
        reaching: how far the body is given to the hands, in [0, 1].
        posture: joint posture, shape (nj,) [rad].
        palms: goals of those of these hands that are turned, or held relative to the other one.
        arms: joints, by their indices, that are commanded by name: the posture has their angles.
        firmness: factors of the cost of height and of those of pelvis and torso: above 1 they are kept from the hands.
        swings: the foot that is in the air, None if none is: balance is worth more than where exactly it is.
    """

    com: Array
    soles: Mapping[Side, Array]
    sole_footings: Mapping[Side, Array]
    sole_corrections: Mapping[Side, Array]
    heading: float
    torso_yaw: float
    lean: tuple[float, float]
    gaze: tuple[float, float]
    hands: Mapping[Side, Array]
    reaching: float
    posture: Array
    palms: Mapping[Side, HandTarget] = field(default_factory=dict)
    arms: Sequence[int] = ()
    firmness: tuple[float, float] = (1.0, 1.0)
    swings: Side | None = None
    tilt: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)


class BodyTask(RowsTask):
    """Centre of mass, soles, pelvis, torso, view and posture, and how much the body spins.

    They are followed in every control period. A task of mink's for each of them costs as much as the whole rest of a
    period: here all of them fill one matrix in place. The errors are those of resolved-rate control: of positions the
    difference, of orientations the rotation vector from where it is to its target, both in the world frame, with the
    geometric Jacobian (Siciliano, Sciavicco, Villani, Oriolo, "Robotics", 2009, section 3.7.3). The last row is the
    angular momentum about the vertical, which is to be none (Kajita et al., "Resolved momentum control", 2003): what
    legs have of it that swing, the ground must give through a sole that can turn on it, if not arms and trunk do.

    Args:
        robot: the robot.
        model: its model as the inverse kinematics has it.
    """

    def __init__(self, robot: RobotModel, model: mujoco.MjModel) -> None:
        config, weights = robot.config, robot.config.whole_body
        self._weights = weights
        joints = model.nv - BASE_DOFS
        self._spins = weights.spin > 0
        count = 3 * (3 + 2 * len(SIDES) + bool(config.neck)) + joints + self._spins
        super().__init__(count, model.nv)
        self._com_error = self.error[:3]
        self._com_cost, self._base_cost, self._torso_cost = (self.cost[rows : rows + 3] for rows in (0, _BASE, _TORSO))
        self._feet_roll = config.feet_roll
        self._sole_cost = np.repeat((weights.foot_position, weights.foot_orientation), 3)
        if not self._feet_roll:  # their legs say how feet lean; in the sole's frame that is the first of the rows
            self._sole_cost[3] = 0.0
        self._sole_costs = {side: self.cost[sole : sole + 6] for side, sole in zip(SIDES, _SOLES, strict=True)}
        self._set_sole_costs(None)
        if config.neck:
            self.cost[_GAZE : _GAZE + 3] = weights.gaze
        posture = slice(count - self._spins - joints, count - self._spins)
        self.jacobian[posture, BASE_DOFS:] = np.eye(joints)
        self.cost[posture] = weights.posture
        self._posture_cost = self.cost[posture]
        if self._spins:
            self.cost[-1] = weights.spin
        self._root = model.body(config.base).id
        end = self._root + sum(self._root in carriers(model, body) for body in range(model.nbody))
        self._bodies = slice(self._root, end)  # they stand one after the other
        self._masses = (
            model.body_mass[self._bodies], model.body_inertia[self._bodies], model.body_subtreemass.item(self._root),
            chains(model, range(self._root, end)),
        )  # fmt: skip
        sites = [model.site(sole_site(side)).id for side in SIDES] + [model.site(GAZE_SITE).id] * bool(config.neck)
        self._sites, self._links = np.array(sites), np.array([self._root, model.body(config.torso).id])
        self._chains = chains(model, [*model.site_bodyid[self._sites], *self._links])
        self._data: mujoco.MjData | None = None  # of which the views are
        self._arms: Sequence[int] = ()
        self._given = (-1.0, -1.0, (1.0, 1.0))  # to the hands, how far it leans for the eyes, and its firmness
        self._bends = 0.0  # share of what a hand bends the torso further than the eyes need that it may stay bent

    def aim(self, data: mujoco.MjData, targets: BodyTargets) -> None:
        """Take the targets of this control period, and how far the body is from them now."""
        if (given := (targets.reaching, targets.lean[1], targets.firmness)) != self._given:
            self._given = given
            self._give_body_to_hands(*given)
        if data is not self._data:
            self._data, self._aim = data, self._bound(data)
        soles, footings, corrections = targets.soles, targets.sole_footings, targets.sole_corrections
        self._aim(
            targets.com, targets.posture, soles["left"], footings["left"], corrections["left"],
            soles["right"], footings["right"], corrections["right"], targets.heading, targets.torso_yaw,
            targets.lean[0], self._torso_lean(data, targets), *targets.gaze, *targets.tilt,
        )  # fmt: skip
        if targets.swings != self._swings:
            self._set_sole_costs(targets.swings)
        if targets.arms != self._arms:
            self._arms = targets.arms
            self._posture_cost[:] = self._weights.posture
            self._posture_cost[list(self._arms)] = self._weights.arm

    def _bound(self, data: mujoco.MjData) -> Callable[..., None]:
        """Return :func:`_aim` for a configuration."""
        return _aim.bind(
            self.jacobian, self.error, self.jacobian[-1] if self._spins else np.zeros(0), self._feet_roll, data.qpos,
            data.cdof, data.subtree_com[self._root], data.xipos[self._bodies], data.ximat[self._bodies], *self._masses,
            data.site_xpos, data.site_xmat, data.xquat, self._sites, self._links, self._chains,
        )  # fmt: skip

    @property
    def com_error(self) -> Array:
        """From where the centre of mass was planned to be to its target, shape (3,) [m]."""
        return self._com_error

    @property
    def damping(self) -> float:
        """How much it damps now.

        A centre of mass that the legs do not reach would have them stretched, and bent again by the next plan: it damps
        less and less near its target.
        """
        error = self._com_cost * self._com_error
        return self._weights.com_damping * float(error.dot(error))

    def _torso_lean(self, data: mujoco.MjData, targets: BodyTargets) -> float:
        """Return how far the torso is to lean ahead [rad]: as the eyes need it, or further where a hand bends it.

        Brought up for the eyes as soon as they need it to lean a little, it would come up, they would need nothing,
        and it would go down again, many times a second.
        """
        needed = targets.lean[1]
        if not (needed and self._bends):
            return needed
        x, y, z = data.xmat[self._links[1], 2::3].tolist()  # the torso's upward axis
        leans = math.atan2(x * math.cos(targets.heading) + y * math.sin(targets.heading), z)
        return needed + self._bends * max(0.0, leans - needed)

    def _set_sole_costs(self, swings: Side | None) -> None:
        """Set what the soles cost: one that swings is no reason to fall, where its leg is at a limit."""
        self._swings = swings
        for side, cost in self._sole_costs.items():
            cost[:] = self._sole_cost * (_SWINGS if side == swings else 1.0)

    def _give_body_to_hands(self, reaching: float, lean: float, firmness: tuple[float, float]) -> None:
        """Set what height, pelvis and torso cost; while the eyes need the torso to lean it is not turned away."""
        weights, held = self._weights, min(1.0, lean / _LEANS)
        torso = weights.reach_torso + held * (weights.torso_orientation - weights.reach_torso)
        pull = (weights.reach_torso / torso) ** 2 if torso else 1.0  # then it is pulled up no harder than for no eyes
        self._bends = reaching * (1 - pull)
        height, turns = firmness
        self._com_cost[:] = (*weights.com[:2], height * _blend(weights.com[2], weights.reach_height, reaching))
        self._base_cost[:] = turns * _blend(weights.base_orientation, weights.reach_base, reaching)
        self._torso_cost[:] = turns * _blend(weights.torso_orientation, torso, reaching)


def _blend(free: float, reaching: float, share: float) -> float:
    """Return a cost between two; cubic, because a little of the free cost moves a body that leans a lot."""
    taken = (1 - share) ** 3
    return free * taken + reaching * (1 - taken)


@inlined
def _sole_goal(sole: Array, footing: Array, correction: Array) -> tuple[Vector, Quaternion]:
    """Return where a sole is to be, and how it is to be turned."""
    turn = tilted((math.cos(sole[2] / 2), 0.0, 0.0, math.sin(sole[2] / 2)), footing[1], footing[2])
    x, y, z = correction[3], correction[4], correction[5]
    if x * x + y * y + z * z > _NO_TURN:
        turn = product(of_vector(x, y, z), turn)
    return (sole[0] + correction[0], sole[1] + correction[1], footing[0] + correction[2]), turn


@inlined
def _in_frame(axes: Array, vector: Array) -> None:
    """Turn a vector from the world into a frame, whose rotation matrix has its numbers in a row, shape (9,)."""
    x, y, z = vector[0], vector[1], vector[2]
    for axis in range(3):
        vector[axis] = axes[axis] * x + axes[3 + axis] * y + axes[6 + axis] * z


@inlined
def _aim_sole(
    jacobian: Array,
    error: Array,
    goal: Vector,
    goal_turn: Quaternion,
    feet_roll: bool,
    motions: Array,
    origin: Array,
    place: Array,
    turn: Array,
    chain: Indices,
) -> None:
    """Write the rows of a sole: see :func:`_aim`; ``place`` and ``turn`` say where it is."""
    point_moves(motions, origin, place, chain, jacobian[:3])
    link_turns(motions, chain, jacobian[3:])
    off = between(of_matrix(turn), goal_turn)
    for axis in range(3):
        error[axis], error[3 + axis] = goal[axis] - place[axis], off[axis]
    if not feet_roll:
        for dof in chain:
            if dof < 0:
                break
            _in_frame(turn, jacobian[3:, dof])
        _in_frame(turn, error[3:])


@bindable(
    "void(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8, f8, f8, f8, f8, f8, f8, f8, f8,"
    " f8)",
    "f8[:, ::1], f8[::1], f8[::1], b1, f8[::1], f8[:, ::1], f8[::1], f8[:, ::1], f8[:, ::1], f8[::1], f8[:, ::1], f8,"
    " i8[:, ::1], f8[:, ::1], f8[:, ::1], f8[:, ::1], i8[::1], i8[::1], i8[:, ::1]",
)
def _aim(
    com: Array,
    posture: Array,
    left_sole: Array,
    left_footing: Array,
    left_correction: Array,
    right_sole: Array,
    right_footing: Array,
    right_correction: Array,
    heading: float,
    torso_yaw: float,
    base_lean: float,
    torso_lean: float,
    gaze_yaw: float,
    gaze_pitch: float,
    base_about_x: float,
    base_about_y: float,
    torso_about_x: float,
    torso_about_y: float,
    jacobian: Array,
    error: Array,
    spins: Array,
    feet_roll: bool,
    qpos: Array,
    motions: Array,
    origin: Array,
    body_places: Array,
    body_turns: Array,
    masses: Array,
    inertias: Array,
    whole: float,
    bodies_moved_by: Indices,
    places: Array,
    turns: Array,
    link_quaternions: Array,
    sites: Indices,
    links: Indices,
    moved_by: Indices,
) -> None:
    """Write the rows of everything.

    Args:
        com, posture: as :class:`BodyTargets` has them, as those that follow.
        left_sole, left_footing, left_correction, right_sole, right_footing, right_correction: of the soles.
        heading, torso_yaw, base_lean, torso_lean, gaze_yaw, gaze_pitch: [rad].
        base_about_x, base_about_y, torso_about_x, torso_about_y: how both are tilted besides [rad].
        jacobian, error: are written.
        spins: the last row if the robot's spin counts, and empty if not.
        feet_roll: whether a joint rolls the feet; otherwise their turn counts in their own frame.
        qpos: as it is.
        motions, origin: as :func:`~humanoid_bt.control.jacobians.point_moves` wants them.
        body_places, body_turns, masses, inertias, whole, bodies_moved_by: of all bodies, as
            :func:`~humanoid_bt.control.jacobians.momenta` wants them.
        places, turns: positions and rotation matrices of all sites.
        link_quaternions: of all bodies.
        sites: the soles, and the eyes if they are turned.
        links: base and torso.
        moved_by: the degrees of freedom of all of these.
    """
    momenta(
        motions, origin, body_places, body_turns, masses, inertias, whole, bodies_moved_by, jacobian[:3], spins
    )  # fmt: skip
    for axis in range(3):
        error[axis] = com[axis] - origin[axis]
    first = len(error) - len(posture) - (len(spins) > 0)
    for joint in range(len(posture)):
        error[first + joint] = posture[joint] - qpos[BASE_COORDINATES + joint]
    for foot in range(2):
        row, site = _SOLES[foot], sites[foot]
        if foot == 0:
            place, turn = _sole_goal(left_sole, left_footing, left_correction)
        else:
            place, turn = _sole_goal(right_sole, right_footing, right_correction)
        rows, off = jacobian[row : row + 6], error[row : row + 6]
        _aim_sole(rows, off, place, turn, feet_roll, motions, origin, places[site], turns[site], moved_by[foot])
    base = _BASE, base_lean, 0.0, base_about_x, base_about_y
    torso = _TORSO, torso_lean, torso_yaw, torso_about_x, torso_about_y
    for link, (row, lean, yaw, about_x, about_y) in enumerate((base, torso)):
        goal = tilted(leaning(0.0, lean, yaw), about_x, about_y)
        goal = product((math.cos(heading / 2), 0.0, 0.0, math.sin(heading / 2)), goal)
        link_turns(motions, moved_by[len(sites) + link], jacobian[row : row + 3])
        now = link_quaternions[links[link]]
        turn_left = between((now[0], now[1], now[2], now[3]), goal)
        for axis in range(3):
            error[row + axis] = turn_left[axis]
    if len(sites) > 2:
        link_turns(motions, moved_by[2], jacobian[_GAZE : _GAZE + 3])
        turn_left = between(of_matrix(turns[sites[2]]), view_along(heading + gaze_yaw, gaze_pitch))
        for axis in range(3):
            error[_GAZE + axis] = turn_left[axis]
