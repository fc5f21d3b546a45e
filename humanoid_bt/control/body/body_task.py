"""What the body always follows, as one task of mink's: the rows of one least-squares problem."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import mink
import mujoco
import numpy as np
from mink.tasks import BaseTask

from humanoid_bt.core.geometry import exp, leaning, planar_pose, pose_product, tilted, view_along
from humanoid_bt.core.messages import SIDES, Array, HandTarget, Side
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, GAZE_SITE, RobotModel, sole_site

_NO_TWIST = 1e-14  # square of a twist too small to matter
_LEANS = 0.3  # rad of lean for the gaze at which a reaching hand does not move the torso any more


@dataclass(frozen=True)
class BodyTargets:
    """What the whole body shall do in this control period; world frame.

    Attributes:
        com: centre of mass, shape (3,) [m].
        soles: pose (x, y, yaw) of each sole.
        sole_footings: height of each sole, and its tilt about the world's x and y [m, rad].
        sole_twists: correction of each sole's pose, shape (6,).
        heading: of the pelvis [rad].
        torso_yaw: of the torso relative to the heading [rad].
        lean: of the pelvis and of the torso ahead [rad].
        gaze: (yaw relative to the heading, pitch) of the view [rad].
        hands: palm positions, shape (3,) [m], of the hands that are commanded.
        reaching: how far the body is given to the hands, in [0, 1].
        posture: joint posture, shape (nj,) [rad].
        palms: goals of those of these hands that are turned, or held relative to the other one.
        arms: joints, by their indices, that are commanded by name: the posture has their angles.
        firmness: factor of the costs of height, pelvis and torso: above 1 they are kept from the hands.
    """

    com: Array
    soles: Mapping[Side, Array]
    sole_footings: Mapping[Side, Array]
    sole_twists: Mapping[Side, Array]
    heading: float
    torso_yaw: float
    lean: tuple[float, float]
    gaze: tuple[float, float]
    hands: Mapping[Side, Array]
    reaching: float
    posture: Array
    palms: Mapping[Side, HandTarget] = field(default_factory=dict)
    arms: Sequence[int] = ()
    firmness: float = 1.0


class _Rows:
    """Three rows of the problem, world frame: a position [m] or an orientation, as a rotation vector [rad].

    Attributes:
        jacobian: how it moves with the degrees of freedom, shape (3, nv).
        error: from where it is to its target, shape (3,).
        cost: of an error, shape (3,); 0 takes no part.
    """

    def __init__(self, task: BodyTask, first: int, cost: float) -> None:
        rows = slice(first, first + 3)
        self.jacobian, self.error, self.cost = task.jacobian[rows], task.error[rows], task.cost[rows]
        self.cost[:] = cost


class BodyTask(BaseTask):  # type: ignore[misc]  # mink has no types
    """Centre of mass, soles, pelvis, torso, view and posture.

    They are followed in every control period. A task of mink's for each of them costs as much as the whole rest of a
    period: here all of them fill one matrix in place. The errors are those of resolved-rate control: of positions the
    difference, of orientations the rotation vector from where it is to its target, both in the world frame, with the
    geometric Jacobian (Siciliano, Sciavicco, Villani, Oriolo, "Robotics", 2009, section 3.7.3).

    Args:
        robot: the robot.
        model: its model as the inverse kinematics has it.

    Attributes:
        jacobian: shape (rows, nv).
        error: shape (rows,).
        cost: shape (rows,).
    """

    def __init__(self, robot: RobotModel, model: mujoco.MjModel) -> None:
        config, weights = robot.config, robot.config.whole_body
        self._weights, self._model = weights, model
        joints = model.nv - BASE_DOFS
        count = 3 * (3 + 2 * len(SIDES) + bool(config.neck)) + joints
        self.jacobian, self.error, self.cost = np.zeros((count, model.nv)), np.zeros(count), np.zeros(count)
        self._column, self._weighted = self.cost[:, None], np.zeros_like(self.jacobian)
        self._turn, self._quaternion = np.zeros(3), np.zeros(4)
        firsts = iter(range(0, count, 3))

        def rows(cost: float) -> _Rows:
            return _Rows(self, next(firsts), cost)

        self._com = rows(0.0)
        self._soles = {side: (rows(weights.foot_position), rows(weights.foot_orientation)) for side in SIDES}
        self._feet_roll = config.feet_roll
        if not self._feet_roll:  # their legs say how feet lean; in the sole's frame that is the first of the rows
            for _, turn in self._soles.values():
                turn.cost[0] = 0.0
        self._base, self._torso = rows(0.0), rows(0.0)
        self._gaze = rows(weights.gaze) if config.neck else None
        posture = next(firsts)
        self.jacobian[posture:, BASE_DOFS:] = np.eye(joints)
        self.cost[posture:] = weights.posture
        self._posture_error, self._posture_cost = self.error[posture:], self.cost[posture:]
        self._root, self._trunk = model.body(config.base).id, model.body(config.torso).id
        self._sole_sites = {side: model.site(sole_site(side)).id for side in SIDES}
        self._gaze_site = model.site(GAZE_SITE).id if config.neck else -1
        self._arms: Sequence[int] = ()
        self._given = (-1.0, -1.0, 1.0)  # to the hands, how far it leans for the eyes, and its firmness

    def aim(self, data: mujoco.MjData, targets: BodyTargets) -> None:
        """Take the targets of this control period, and how far the body is from them now."""
        model = self._model
        mujoco.mj_jacSubtreeCom(model, data, self._com.jacobian, self._root)
        np.subtract(targets.com, data.subtree_com[self._root], out=self._com.error)
        for side, (position, turn) in self._soles.items():
            x, y, yaw = targets.soles[side].tolist()
            z, roll, pitch = targets.sole_footings[side].tolist()
            pose = planar_pose(x, y, z, yaw)
            pose[3:] = tilted(pose[3:], roll, pitch)
            twist = targets.sole_twists[side]
            if twist.dot(twist) > _NO_TWIST:
                pose = pose_product(exp(twist), pose)
            site = self._sole_sites[side]
            mujoco.mj_jacSite(model, data, position.jacobian, turn.jacobian, site)
            np.subtract(pose[:3], data.site_xpos[site], out=position.error)
            self._turn_site(data, turn, site, pose[3:])
            if not self._feet_roll:
                axes = data.site_xmat[site].reshape(3, 3)
                turn.jacobian[:], turn.error[:] = axes.T @ turn.jacobian, axes.T @ turn.error
        base_lean, torso_lean = targets.lean
        self._turn_body(data, self._base, self._root, leaning(targets.heading, base_lean))
        self._turn_body(data, self._torso, self._trunk, leaning(targets.heading, torso_lean, targets.torso_yaw))
        if self._gaze is not None:
            yaw, pitch = targets.gaze
            mujoco.mj_jacSite(model, data, None, self._gaze.jacobian, self._gaze_site)
            goal = view_along(targets.heading + yaw, pitch)
            self._turn_site(data, self._gaze, self._gaze_site, goal)
        np.subtract(targets.posture, data.qpos[BASE_COORDINATES:], out=self._posture_error)
        if targets.arms != self._arms:
            self._arms = targets.arms
            self._posture_cost[:] = self._weights.posture
            self._posture_cost[list(self._arms)] = self._weights.arm
        if (targets.reaching, torso_lean, targets.firmness) != self._given:
            self._give_body_to_hands(targets.reaching, torso_lean, targets.firmness)

    @property
    def com_error(self) -> Array:
        """From where the centre of mass was planned to be to its target, shape (3,) [m]."""
        return self._com.error

    def compute_qp_residual(self, configuration: mink.Configuration) -> tuple[Array, Array, float]:
        """Return the weighted Jacobian, which stays until the next time, the weighted error, and no damping."""
        np.multiply(self._column, self.jacobian, out=self._weighted)
        return self._weighted, self.cost * self.error, 0.0

    def compute_qp_objective(self, configuration: mink.Configuration) -> mink.Objective:
        """Return the same as a quadratic objective."""
        jacobian, error, _ = self.compute_qp_residual(configuration)
        return mink.Objective(jacobian.T @ jacobian, -(error @ jacobian))

    def _turn_body(self, data: mujoco.MjData, rows: _Rows, body: int, goal: Array) -> None:
        mujoco.mj_jacBody(self._model, data, None, rows.jacobian, body)
        self._turn_to(goal, data.xquat[body], rows.error)

    def _turn_site(self, data: mujoco.MjData, rows: _Rows, site: int, goal: Array) -> None:
        mujoco.mju_mat2Quat(self._quaternion, data.site_xmat[site])
        self._turn_to(goal, self._quaternion, rows.error)

    def _turn_to(self, goal: Array, now: Array, turn: Array) -> None:
        """Write the rotation vector, world frame, that turns one orientation into another; quaternions wxyz."""
        mujoco.mju_subQuat(self._turn, goal, now)
        mujoco.mju_rotVecQuat(turn, self._turn, now)

    def _give_body_to_hands(self, reaching: float, lean: float, firmness: float) -> None:
        weights = self._weights
        self._given = (reaching, lean, firmness)
        torso = _blend(weights.reach_torso, weights.torso_orientation, min(1.0, lean / _LEANS))  # the eyes need it
        self._com.cost[:] = (*weights.com[:2], firmness * _blend(weights.com[2], weights.reach_height, reaching))
        self._base.cost[:] = firmness * _blend(weights.base_orientation, weights.reach_base, reaching)
        self._torso.cost[:] = firmness * _blend(weights.torso_orientation, torso, reaching)


def _blend(free: float, reaching: float, share: float) -> float:
    """Return a cost between two; cubic, because a little of the free cost moves a body that leans a lot."""
    taken = (1 - share) ** 3
    return free * taken + reaching * (1 - taken)
