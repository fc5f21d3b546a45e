"""Inverse kinematics of the joints that a learned walker lends: the rest of the robot is where it is measured."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import mink
import mujoco
import numpy as np

from humanoid_bt.control.body.mink_terms import frame_task
from humanoid_bt.control.body.palm_task import PalmTask
from humanoid_bt.control.body.policy.lending import rolls
from humanoid_bt.control.body.quadratic_program import QuadraticProgram
from humanoid_bt.control.body.self_collision import SelfCollisionLimit
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.geometry import clamp, view_along
from humanoid_bt.core.messages import SIDES, Array, HandTarget, Side
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, GAZE_SITE, RobotModel, carriers, palm_site
from humanoid_bt.robot.policy.policy import Indices

_FASTEST = 2.5  # rad/s of a lent joint
# The walker balances on what the waist does, so that it must be slow:
_WAIST_SPEED, _WAIST_RANGE = 0.3, 0.5  # rad/s; rad from home
_YAW_SPEED, _YAW_RANGE = 0.6, 0.65  # likewise where it only turns: G1 steps on its own from 0.8 on, and falls at 1.2
_ROLL_SPEED = 0.05  # rad/s where it leans aside: walkers step back from faster ones, away from what is reached for
_UPRIGHT = 0.7  # of the vertical part of a joint's axis that only turns
_WAIST_COST = 5.0  # times that of other joints


class UpperBody:
    """The planned motion of lent joints, one differential step per control period.

    The same tasks and limits as those of the whole body, of which it takes the columns of the lent joints. Palms are
    commanded in the world, so the base is where it is measured, and what the legs do is made up for.

    Args:
        robot: the robot.
        waist: joints of the waist that may be lent, as indices.
        dt: control period [s].

    Attributes:
        joints: planned angles of all joints, shape (nj,) [rad]; those that are not lent are as measured.
        velocity: of lent joints, of others 0, shape (nj,) [rad/s].
        still: joints that stay as they are; set it.
        solved: whether the last step had a solution.
    """

    def __init__(self, robot: RobotModel, waist: list[int], dt: float) -> None:
        self._dt, self._palm_axes = dt, robot.palm_axes
        weights = robot.config.whole_body
        self._own_links = SelfCollisionLimit(robot)
        self._model = model = self._own_links.model
        self._configuration = mink.Configuration(model)
        self._data = self._configuration.data
        self._sites = {side: model.site(palm_site(side)).id for side in SIDES if side in robot.config.hands}
        self._hands = {
            side: frame_task(palm_site(side), "site", weights.hand, 0.0, weights.hand_damping) for side in self._sites
        }
        self._turned_hands = {side: PalmTask(robot, model, side) for side in self._sites}
        gaze = weights.gaze if robot.config.neck else weights.torso_orientation
        self._posture, self._gaze = _PostureTask(), _GazeTask(model, self._data, gaze)
        trunk = set(carriers(model, model.body(robot.config.torso).id))
        self._arms = {
            side: [body for body in carriers(model, model.body(robot.config.hands[side].body).id) if body not in trunk]
            for side in self._sites
        }
        self._damping = weights.damping
        self._farthest = np.minimum(robot.speed_limit, _FASTEST) * dt
        axes = robot.axes[waist]
        turns = np.abs(axes[:, 2]) > _UPRIGHT
        speeds = np.where(turns, _YAW_SPEED, np.where(rolls(axes), _ROLL_SPEED, _WAIST_SPEED))
        self._farthest[waist] = speeds * dt
        ranges = np.where(turns, _YAW_RANGE, _WAIST_RANGE)
        self._lower, self._upper = robot.lower.copy(), robot.upper.copy()
        home = robot.home_qpos[BASE_COORDINATES:]
        self._lower[waist] = np.maximum(self._lower[waist], home[waist] - ranges)
        self._upper[waist] = np.minimum(self._upper[waist], home[waist] + ranges)
        self._weight = np.ones(len(home))
        self._weight[waist] = _WAIST_COST
        self._programs: dict[int, QuadraticProgram] = {}
        self._goals: Mapping[Side, Array] = {}
        self.joints: Array = robot.home_qpos[BASE_COORDINATES:].copy()
        self.reset(self.joints)

    def reset(self, joints: Array) -> None:
        """Begin at rest where the joints are, shape (nj,) [rad]."""
        self.joints = joints.copy()
        self.velocity: Array = np.zeros(len(joints))
        self.still: list[int] = []
        self.solved = True
        self._goals = {}
        self._own_links.look()

    def see(self, qpos: Array, lent: Indices) -> None:
        """Take where the robot is, shape (7 + nj,): all but the lent joints, which are where they are planned."""
        known = qpos.copy()
        known[BASE_COORDINATES:][lent] = self.joints[lent]
        self.joints = known[BASE_COORDINATES:].copy()
        self._configuration.update(known)

    def follow(self, joints: list[int], measured: Array, share: float) -> None:
        """Move some joints of the plan toward where they are measured, by a share of the way."""
        moved = self.joints[joints] + share * (measured - self.joints[joints])
        self.joints[joints] = clamp(moved, self._lower[joints], self._upper[joints])
        self._own_links.look()

    def palm(self, side: Side) -> Array:
        """Return the planned place of a palm, world frame, shape (3,)."""
        return np.array(self._data.site_xpos[self._sites[side]])

    def palm_frame(self, side: Side) -> Array:
        """Return how it is turned: the rotation matrix of its frame, shape (3, 3)."""
        return np.asarray(self._data.site_xmat[self._sites[side]].reshape(3, 3) @ self._palm_axes[side])

    @property
    def view(self) -> tuple[float, float]:
        """Yaw and pitch of the planned view, world frame [rad]."""
        x, y, z = self._gaze.along.tolist()
        return math.atan2(y, x), -math.atan2(z, math.hypot(x, y))

    def hand_error(self, side: Side) -> float | None:
        """How far a planned palm is from where the last step was to bring it [m]; None if nothing commands it."""
        goal = self._goals.get(side)
        return None if goal is None else math.dist(goal.tolist(), self._data.site_xpos[self._sites[side]].tolist())

    @property
    def hand_obstacles(self) -> dict[Side, str]:
        """The body that keeps a commanded palm from its target, of those that one keeps."""
        found: dict[Side, str] = {}
        for side, goal in self._goals.items():
            jacobian = np.zeros((3, self._model.nv))
            mujoco.mj_jacSite(self._model, self._data, jacobian, None, self._sites[side])
            pull = (goal - self._data.site_xpos[self._sites[side]]) @ jacobian
            if body := self._own_links.obstacle(self._arms[side], pull):
                found[side] = body
        return found

    def step(
        self,
        free: Indices,
        kept: Indices,
        hands: Mapping[Side, Array],
        palms: Mapping[Side, HandTarget],
        *,
        posture: Array,
        costs: Array,
        view: tuple[float, float] | None,
    ) -> None:
        """Move the lent joints one control period toward the targets.

        Args:
            free: those that the targets move, as indices.
            kept: the others, which only follow the posture.
            hands: places of commanded palms, shape (3,), world frame [m].
            palms: goals of those that are more than a place.
            posture: of all joints, shape (nj,) [rad].
            costs: of an error of it, shape (nj,).
            view: yaw and pitch of the view, world frame [rad]; None where it does not matter.
        """
        self._goals = hands
        dofs = free + BASE_DOFS
        self._posture.aim(posture[free] - self.joints[free], (self._weight * costs)[free])
        tasks: list[_Columns | _PostureTask] = [self._posture]
        for side, position in hands.items():
            if goal := palms.get(side):
                self._turned_hands[side].aim(self._data, goal)
                tasks.append(_Columns(self._turned_hands[side], dofs))
            else:
                self._hands[side].set_target(mink.SE3.from_translation(position))
                tasks.append(_Columns(self._hands[side], dofs))
        if view is not None:
            self._gaze.aim(*view)
            tasks.append(_Columns(self._gaze, dofs))
        way = self._way(free, dofs, tasks) if len(free) else np.zeros(0)
        self.solved = way is not None
        if way is None:
            free, way = free[:0], np.zeros(0)
        self.velocity = np.zeros(len(self.joints))
        _go(self.joints, self.velocity, kept, free, way, posture, self._farthest, self._dt)

    def _way(self, free: Indices, dofs: Indices, tasks: Iterable[_Columns | _PostureTask]) -> Array | None:
        """Return how far the free joints go, shape (len(free),); None if there is no solution."""
        program = self._programs.get(len(free))
        if program is None:
            program = self._programs[len(free)] = QuadraticProgram(len(free), self._damping)
        limit = _OwnLinkColumns(self._own_links, dofs)
        program.aim(self._configuration, list(tasks))
        program.limit(self._configuration, [limit], self._dt)
        _bound(program.low, program.high, free, self.joints, self._lower, self._upper, self._farthest)
        if self.still:
            still = np.isin(free, self.still)
            program.low[still] = program.high[still] = 0.0
        way = program.solve()
        if way is None and (program.rooms < 0).any():
            np.maximum(program.rooms, 0.0, out=program.rooms)  # not all can part that are too near: they stay
            way = program.solve()
        if way is not None:
            limit.note(program.pressures)
        return way


class _Columns:
    """A task as far as some degrees of freedom serve it."""

    def __init__(self, task: mink.BaseTask | PalmTask | _GazeTask, dofs: Indices) -> None:
        self._task, self._dofs = task, dofs

    def compute_qp_residual(self, configuration: mink.Configuration) -> tuple[Array, Array, float]:
        """Return the weighted Jacobian, the weighted error and the damping."""
        jacobian, error, damping = self._task.compute_qp_residual(configuration)
        return jacobian[:, self._dofs], error, damping


class _OwnLinkColumns:
    """The limit that keeps own links apart, as far as some degrees of freedom can."""

    def __init__(self, limit: SelfCollisionLimit, dofs: Indices) -> None:
        self._limit, self._dofs = limit, dofs
        self._moved = np.zeros(0, dtype=bool)

    def compute_qp_inequalities(self, configuration: mink.Configuration, dt: float) -> mink.Constraint:
        """Return how far those may approach each other of which one is moved."""
        rows, rooms = self._limit.compute_qp_inequalities(configuration, dt)
        if rows is None or rooms is None:
            self._moved = np.zeros(0, dtype=bool)
            return mink.Constraint()
        own = rows[:, self._dofs]
        self._moved = np.abs(own).max(axis=1) > 0
        return mink.Constraint(own[self._moved], rooms[self._moved])

    def note(self, pressures: Array) -> None:
        """Take how hard the targets press links against each other."""
        if len(self._moved):
            whole = np.zeros(len(self._moved))
            whole[self._moved] = pressures[: int(self._moved.sum())]
            self._limit.pressures = whole


class _PostureTask:
    """The posture of the lent joints."""

    def aim(self, error: Array, cost: Array) -> None:
        """Take how far they are from it, shape (n,) [rad], and what that costs."""
        self._error, self._cost = error, cost

    def compute_qp_residual(self, _configuration: mink.Configuration) -> tuple[Array, Array, float]:
        """Return the weighted Jacobian, the weighted error, and no damping."""
        return np.diag(self._cost), self._cost * self._error, 0.0


class _GazeTask:
    """Where the view goes; it need not be level, so that the trunk may lean aside for a hand.

    Args:
        model, data: of the planned motion.
        cost: of an error [1/rad].

    Attributes:
        along: where the view goes now, unit vector, shape (3,).
    """

    def __init__(self, model: mujoco.MjModel, data: mujoco.MjData, cost: float) -> None:
        self._model, self._data, self._cost, self._site = model, data, cost, model.site(GAZE_SITE).id
        self._frame = data.site_xmat[self._site]
        self.along: Array = self._frame[::3]
        self._jacobian, self._error = np.zeros((3, model.nv)), np.zeros(3)
        self._now, self._turn = np.zeros(4), np.zeros(3)

    def aim(self, yaw: float, pitch: float) -> None:
        """Take where it is to go, world frame [rad]."""
        along = self.along
        mujoco.mj_jacSite(self._model, self._data, None, self._jacobian, self._site)
        mujoco.mju_mat2Quat(self._now, self._frame)
        mujoco.mju_subQuat(self._turn, view_along(yaw, pitch), self._now)
        mujoco.mju_rotVecQuat(self._error, self._turn, self._now)
        self._jacobian -= along[:, None] * (along @ self._jacobian)
        self._error -= along * (along @ self._error)

    def compute_qp_residual(self, _configuration: mink.Configuration) -> tuple[Array, Array, float]:
        """Return the weighted Jacobian, the weighted error, and no damping."""
        return self._cost * self._jacobian, self._cost * self._error, 0.0


@compiled("void(f8[::1], f8[::1], i8[::1], f8[::1], f8[::1], f8[::1], f8[::1])")
def _bound(low: Array, high: Array, free: Indices, joints: Array, lower: Array, upper: Array, farthest: Array) -> None:
    """Write how far some joints may go in a control period: one beyond its limits need not come back at once.

    Args:
        low, high: are written, shape (len(free),) [rad].
        free: those joints, as indices.
        joints, lower, upper: where all of them are, and their limits, shape (nj,) [rad].
        farthest: how far each goes at its speed, shape (nj,) [rad].
    """
    for i in range(len(free)):
        joint = free[i]
        low[i] = max(min(lower[joint] - joints[joint], 0.0), -farthest[joint])
        high[i] = min(max(upper[joint] - joints[joint], 0.0), farthest[joint])


@compiled("void(f8[::1], f8[::1], i8[::1], i8[::1], f8[::1], f8[::1], f8[::1], f8)")
def _go(
    joints: Array, velocity: Array, kept: Indices, free: Indices, way: Array, posture: Array, farthest: Array, dt: float
) -> None:
    """Move joints by a control period.

    Args:
        joints, velocity: of all of them, shape (nj,) [rad], [rad/s]; are changed.
        kept: those that go to the posture.
        free, way: others, and how far each of them goes, shape (len(free),) [rad].
        posture: of all joints, shape (nj,) [rad].
        farthest: how far each goes at its speed, likewise.
        dt: [s].
    """
    for joint in kept:
        step = min(max(posture[joint] - joints[joint], -farthest[joint]), farthest[joint])
        velocity[joint] = step / dt
        joints[joint] += step
    for i in range(len(free)):
        velocity[free[i]] = way[i] / dt
        joints[free[i]] += way[i]
