"""Whole-body inverse kinematics with mink: one differential step per control period from the last setpoint."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mink
import mujoco
import numpy as np

from humanoid_bt.control.body.height_limit import HeightLimit
from humanoid_bt.control.body.mink_terms import SOLVER, frame_task, leaning, se3, view_along, within_soft_limits
from humanoid_bt.core.geometry import clamp, exp, planar_pose, pose_product
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, GAZE_SITE, RobotModel, palm_site, sole_site

_NO_TWIST = 1e-14  # square of a twist too small to matter
_ACCELERATION_LIMIT = 100.0  # rad/s^2, of the planned motion, as it goes into the feedforward
_LEANS = 0.3  # rad of lean for the gaze at which a reaching hand does not move the torso any more
_SMOOTH_TIME = 0.02  # s, low-pass of planned acceleration and momentum rate


@dataclass(frozen=True)
class BodyTargets:
    """What the whole body shall do in this control period; world frame.

    Attributes:
        com: centre of mass, shape (3,) [m].
        soles: pose (x, y, yaw) of each sole.
        sole_heights: [m].
        sole_twists: correction of each sole's pose, shape (6,).
        heading: of the pelvis [rad].
        torso_yaw: of the torso relative to the heading [rad].
        lean: of the pelvis and of the torso ahead [rad].
        gaze: (yaw relative to the heading, pitch) of the view [rad].
        hands: palm positions, shape (3,) [m], of the hands that are commanded.
        reaching: how far the body is given to the hands, in [0, 1].
        posture: joint posture, shape (nj,) [rad].
    """

    com: Array
    soles: Mapping[Side, Array]
    sole_heights: Mapping[Side, float]
    sole_twists: Mapping[Side, Array]
    heading: float
    torso_yaw: float
    lean: tuple[float, float]
    gaze: tuple[float, float]
    hands: Mapping[Side, Array]
    reaching: float
    posture: Array


class InverseKinematics:
    """Keeps the configuration of the last setpoint and moves it toward the targets.

    When the solver finds no solution, the body goes on balancing by damped least squares without the limits, which has
    a solution for all finite targets: a body that froze in the middle of a step would fall. The joints are clamped into
    their limits afterwards.

    Args:
        robot: the robot.
        dt: control period [s].

    Attributes:
        velocity: of the planned motion, shape (nv,) [m/s, rad/s].
        acceleration: smoothed, shape (nv,).
        momentum_rate: smoothed rate of the planned motion's angular momentum, shape (3,) [Nm].
        solved: whether the last step had a solution.
        height_limit: how low the base may go.
        configuration, tasks, limits: mink's problem of the last step.
    """

    def __init__(self, robot: RobotModel, dt: float) -> None:
        config, weights = robot.config, robot.config.whole_body
        self._robot, self._weights, self._dt = robot, weights, dt
        self._model = within_soft_limits(robot)
        self.configuration = mink.Configuration(self._model)
        self._com = mink.ComTask(cost=list(weights.com))
        self._soles = {
            side: frame_task(sole_site(side), "site", weights.foot_position, weights.foot_orientation) for side in SIDES
        }
        self._base = frame_task(config.base, "body", 0.0, weights.base_orientation)
        self._torso = frame_task(config.torso, "body", 0.0, weights.torso_orientation)
        self._posture = mink.PostureTask(self._model, cost=weights.posture)
        self._gaze = frame_task(GAZE_SITE, "site", 0.0, weights.gaze) if config.neck else None
        self._hands = {
            side: frame_task(palm_site(side), "site", weights.hand, 0.0, weights.hand_damping)
            for side in SIDES
            if side in config.hands
        }
        self.height_limit = HeightLimit(self._model.nv)
        self.limits: list[mink.Limit] = [mink.ConfigurationLimit(self._model), self.height_limit]
        self.tasks: list[mink.BaseTask] = []
        self._given = (0.0, 0.0)  # to the hands, and how far it leans for the eyes
        self._root = self._model.body(config.base).id
        self._palms = {side: self._model.site(palm_site(side)).id for side in self._hands}
        self.reset(robot.home_qpos)

    def reset(self, qpos: Array) -> None:
        """Start at rest from a configuration, shape (7 + nj,), clamped into the soft limits."""
        start = qpos.copy()
        start[BASE_COORDINATES:] = clamp(start[BASE_COORDINATES:], self._robot.lower, self._robot.upper)
        self.configuration.update(start)
        self.velocity: Array = np.zeros(self._model.nv)
        self.acceleration: Array = np.zeros(self._model.nv)
        self.momentum_rate: Array = np.zeros(3)
        self._momentum: Array = np.zeros(3)
        self.solved = True

    @property
    def base_pose(self) -> Array:
        """Reference of the base: position and quaternion wxyz, shape (7,)."""
        return np.asarray(self.configuration.data.qpos[:BASE_COORDINATES])

    @property
    def joints(self) -> Array:
        """Reference of the joints, shape (nj,) [rad]."""
        return np.asarray(self.configuration.data.qpos[BASE_COORDINATES:])

    @property
    def com_height(self) -> float:
        """Reference of the centre of mass' height [m]."""
        return float(self.configuration.data.subtree_com[self._root][2])

    def palm(self, side: Side) -> Array:
        """Reference position of a palm, world frame, shape (3,)."""
        return np.array(self.configuration.data.site_xpos[self._palms[side]])

    def step(self, targets: BodyTargets) -> bool:
        """Move one control period toward the targets; return whether there was a solution within all limits."""
        self.tasks = self._set_targets(targets)
        try:
            velocity = mink.solve_ik(
                self.configuration,
                self.tasks,
                self._dt,
                solver=SOLVER,
                damping=self._weights.damping,
                limits=self.limits,
            )
            self.solved = bool(np.isfinite(velocity).all())
        except mink.NoSolutionFound:
            self.solved = False
        if not self.solved:
            velocity = self._without_limits()
        self.configuration.integrate_inplace(velocity, self._dt)
        self._follow_motion(velocity)
        return self.solved

    def _without_limits(self) -> Array:
        """Return the velocity of damped least squares, shape (nv,), clamped; zero if even that has no solution."""
        problem = mink.build_ik(self.configuration, self.tasks, self._dt, damping=self._weights.damping, limits=[])
        try:
            way = np.linalg.solve(problem.P, -problem.q)
        except np.linalg.LinAlgError:
            return np.zeros(self._model.nv)
        if not np.isfinite(way).all():
            return np.zeros(self._model.nv)
        after = clamp(self.joints + way[BASE_DOFS:], self._robot.lower, self._robot.upper)
        way[BASE_DOFS:] = after - self.joints
        return np.asarray(way / self._dt)

    def _set_targets(self, targets: BodyTargets) -> list[mink.BaseTask]:
        for side in SIDES:
            x, y, yaw = targets.soles[side]
            pose = planar_pose(x, y, targets.sole_heights[side], yaw)
            twist = targets.sole_twists[side]
            corrected = twist @ twist > _NO_TWIST
            self._soles[side].set_target(se3(pose_product(exp(twist), pose) if corrected else pose))
        self._com.set_target(targets.com)
        base_lean, torso_lean = targets.lean
        self._base.set_target(leaning(targets.heading, base_lean))
        self._torso.set_target(leaning(targets.heading, torso_lean, targets.torso_yaw))
        self._posture.set_target(np.concatenate([self.base_pose, targets.posture]))
        if (targets.reaching, torso_lean) != self._given:
            self._give_body_to_hands(targets.reaching, torso_lean)
        tasks = [self._com, self._soles["left"], self._soles["right"], self._base, self._torso, self._posture]
        if self._gaze is not None:
            yaw, pitch = targets.gaze
            self._gaze.set_target(view_along(targets.heading + yaw, pitch))
            tasks.append(self._gaze)
        for side, position in targets.hands.items():
            self._hands[side].set_target(mink.SE3.from_translation(position))
            tasks.append(self._hands[side])
        return tasks

    def _give_body_to_hands(self, reaching: float, lean: float) -> None:
        weights = self._weights
        self._given = (reaching, lean)
        torso = _blend(weights.reach_torso, weights.torso_orientation, min(1.0, lean / _LEANS))  # the eyes need it
        self._com.set_cost([*weights.com[:2], _blend(weights.com[2], weights.reach_height, reaching)])
        self._base.set_orientation_cost(_blend(weights.base_orientation, weights.reach_base, reaching))
        self._torso.set_orientation_cost(_blend(weights.torso_orientation, torso, reaching))

    def _follow_motion(self, velocity: Array) -> None:
        smooth = min(1.0, self._dt / _SMOOTH_TIME)
        rate = clamp((velocity - self.velocity) / self._dt, -_ACCELERATION_LIMIT, _ACCELERATION_LIMIT)
        self.acceleration += smooth * (rate - self.acceleration)
        self.velocity = velocity
        data = self.configuration.data
        data.qvel[:] = velocity
        mujoco.mj_comVel(self._model, data)
        mujoco.mj_subtreeVel(self._model, data)
        momentum = data.subtree_angmom[self._root].copy()
        self.momentum_rate += smooth * ((momentum - self._momentum) / self._dt - self.momentum_rate)
        self._momentum = momentum


def _blend(free: float, reaching: float, share: float) -> float:
    """Return a cost between two; cubic, because a little of the free cost moves a body that leans a lot."""
    taken = (1 - share) ** 3
    return free * taken + reaching * (1 - taken)
