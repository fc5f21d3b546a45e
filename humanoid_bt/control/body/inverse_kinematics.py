"""Whole-body inverse kinematics with mink: one differential step per control period from the last setpoint."""

from __future__ import annotations

import math
from collections.abc import Mapping

import mink
import mujoco
import numpy as np

from humanoid_bt.control.body.arm_search import ArmSearch
from humanoid_bt.control.body.body_task import BodyTargets, BodyTask
from humanoid_bt.control.body.mink_terms import frame_task
from humanoid_bt.control.body.palm_task import PalmTask
from humanoid_bt.control.body.quadratic_program import QuadraticProgram
from humanoid_bt.control.body.self_collision import SelfCollisionLimit
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel, carriers, palm_site
from humanoid_bt.robot.mujoco_functions import com_pos, com_vel, integrate_pos, kinematics, subtree_vel

# rad/s^2, of the planned motion, as it goes into the feedforward: legs catch a push, an arm that starts is no blow
_ACCELERATION_LIMIT, _ARM_ACCELERATION = 300.0, 100.0
# What was held back and comes free must not catch up so fast that it throws the robot:
_ARM_SPEED = 2.5  # rad/s of its joints
_RISE_SPEED = 0.2  # m/s of the base, up and down
_TURN_SPEED, _LUNGE_SPEED = 1.5, 4.0  # rad/s of the base, and of the waist's joints
_HEIGHT = 2  # coordinate, and degree of freedom, of the free base's height
_SINK_BRAKE_TIME = 0.1  # s in which a sinking base comes to rest above the lowest that it may be
_BRAKE_TIME = 0.05  # s in which a joint comes to rest at its limit: a knee that is stretched at once chatters there
_PARTING = 50.0  # cost per metre of links that do not part, where not all can: that of a foot
_SMOOTH_TIME, _ARM_SMOOTH_TIME = 0.02, 0.03  # s, low-pass of planned acceleration and momentum rate


class InverseKinematics:
    """Keeps the configuration of the last setpoint and moves it toward the targets.

    When the solver finds no solution, the body goes on balancing by damped least squares, which has a solution for all
    finite targets: a body that froze in the middle of a step would fall. Joints and base stay within their limits then,
    and arms stop before other links.

    Args:
        robot: the robot.
        dt: control period [s].

    Attributes:
        base_pose: reference of the base, always up to date: position and quaternion wxyz, shape (7,).
        joints: reference of the joints, likewise, shape (nj,) [rad].
        velocity: of the planned motion, shape (nv,) [m/s, rad/s].
        acceleration: smoothed, shape (nv,).
        momentum_rate: smoothed rate of the planned motion's angular momentum, shape (3,) [Nm].
        solved: whether the last step had a solution.
        still: joints that stay as they are; set it.
        lowest: where the base comes to rest that sinks [m]: a hand that pulls it lower would make a crouch look like a
            fall. A base that is lower already may rise, and does not have to.
        configuration, tasks, limits: mink's problem of the last step.
    """

    def __init__(self, robot: RobotModel, dt: float) -> None:
        self._robot, self._dt = robot, dt
        self._own_links = SelfCollisionLimit(robot)
        self._model = self._own_links.model
        self._program = QuadraticProgram(self._model.nv, robot.config.whole_body.damping)
        self.configuration = mink.Configuration(self._model)
        qpos: Array = self.configuration.data.qpos
        self._qpos, self.base_pose, self.joints = qpos, qpos[:BASE_COORDINATES], qpos[BASE_COORDINATES:]  # views
        self._body = BodyTask(robot, self._model)
        config, weights = robot.config, robot.config.whole_body
        self._hands = {
            side: frame_task(palm_site(side), "site", weights.hand, 0.0, weights.hand_damping)
            for side in SIDES
            if side in config.hands
        }
        self._hand_places = {side: _place_of_target(hand) for side, hand in self._hands.items()}
        self._turned_hands = {side: PalmTask(robot, self._model, side) for side in self._hands}
        self.tasks: list[mink.BaseTask] = [self._body]
        self.limits: list[mink.Limit] = [self._own_links]
        self.lowest = 0.0
        trunk = set(carriers(robot.model, robot.model.body(config.torso).id))
        self._arms = {
            side: [
                body
                for body in carriers(robot.model, robot.model.body(config.hands[side].body).id)
                if body not in trunk
            ]
            for side in self._hands
        }
        self._farthest = robot.speed_limit * dt
        of_arms = np.isin(robot.model.jnt_bodyid[1:], [body for arm in self._arms.values() for body in arm])
        np.minimum(self._farthest, _ARM_SPEED * dt, out=self._farthest, where=of_arms)
        self._quickest: Array = np.full(self._model.nv, _ACCELERATION_LIMIT)
        self._quickest[BASE_DOFS:][of_arms] = _ARM_ACCELERATION
        self._smooth: Array = np.full(self._model.nv, min(1.0, dt / _SMOOTH_TIME))
        self._smooth[BASE_DOFS:][of_arms] = min(1.0, dt / _ARM_SMOOTH_TIME)
        self._of_waist = np.isin(robot.model.jnt_bodyid[1:], list(trunk))
        self._eased = ~of_arms
        self._of_arms = np.concatenate([np.zeros(BASE_DOFS, dtype=bool), of_arms])
        self._freely = self._farthest.copy()
        self.ease(1.0)
        self._program.high[_HEIGHT] = _RISE_SPEED * dt
        self._root = self._model.body(robot.config.base).id
        self._palms = {side: self._model.site(palm_site(side)).id for side in self._hands}
        where = self.configuration.data.site_xpos
        self._palm_positions = {side: where[site] for side, site in self._palms.items()}
        self.reset(robot.home_qpos)

    def reset(self, qpos: Array) -> None:
        """Start at rest from a configuration, shape (7 + nj,), clamped into the soft limits."""
        start = qpos.copy()
        start[BASE_COORDINATES:] = clamp(start[BASE_COORDINATES:], self._robot.lower, self._robot.upper)
        self.configuration.update(start)
        self._own_links.look()
        self.velocity: Array = np.zeros(self._model.nv)
        self.acceleration: Array = np.zeros(self._model.nv)
        self.momentum_rate: Array = np.zeros(3)
        data = self.configuration.data
        self._move = _go.bind(
            self.acceleration, self.momentum_rate, np.zeros(3), self._quickest, self._smooth,
            min(1.0, self._dt / _SMOOTH_TIME), self._dt, self._model._address, data._address,
            self._qpos, data.qvel, data.subtree_angmom[self._root],
        )  # fmt: skip
        self._hand_goals: Mapping[Side, Array] = {}
        self.still: list[int] = []
        self.solved = True

    def follow(self, joints: list[int], measured: Array, share: float) -> None:
        """Move some joints of the configuration toward where they are measured, by a share of the way."""
        qpos = self.configuration.q.copy()
        places = np.add(joints, BASE_COORDINATES)
        qpos[places] += share * (measured - qpos[places])
        qpos[BASE_COORDINATES:] = clamp(qpos[BASE_COORDINATES:], self._robot.lower, self._robot.upper)
        self.configuration.update(qpos)
        self._own_links.look()

    def arm_search(self, side: Side) -> ArmSearch:
        """Return what searches angles of an arm, its own links apart."""
        return ArmSearch(self._robot, self._own_links, side)

    def ease(self, share: float, *, lunges: bool = False) -> None:
        """Say until the next time how fast all but the arms may turn.

        Args:
            share: of what is usual, in (0, 1].
            lunges: whether pelvis and waist may turn faster than usual.
        """
        way = share * (_LUNGE_SPEED if lunges else _TURN_SPEED) * self._dt
        self._program.low[3:BASE_DOFS], self._program.high[3:BASE_DOFS] = -way, way
        self._farthest[self._eased] = share * self._freely[self._eased]
        np.minimum(self._farthest, way, out=self._farthest, where=self._of_waist)

    @property
    def com_height(self) -> float:
        """Reference of the centre of mass' height [m]."""
        return float(self.configuration.data.subtree_com[self._root][2])

    def palm(self, side: Side) -> Array:
        """Reference position of a palm, world frame, shape (3,)."""
        return np.array(self._palm_positions[side])

    def palm_frame(self, side: Side) -> Array:
        """Reference of how a palm is turned: the rotation matrix of its frame, shape (3, 3)."""
        site = self.configuration.data.site_xmat[self._palms[side]].reshape(3, 3)
        return np.asarray(site @ self._robot.palm_axes[side])

    @property
    def com_error(self) -> Array:
        """From where the centre of mass was planned to be to where it was to go in the last step, shape (3,) [m]."""
        return self._body.com_error

    def hand_error(self, side: Side) -> float | None:
        """How far a planned palm is from where the last step was to bring it [m]; None if nothing commands it."""
        goal = self._hand_goals.get(side)
        return None if goal is None else math.dist(goal.tolist(), self._palm_positions[side].tolist())

    @property
    def hand_obstacles(self) -> dict[Side, str]:
        """The body that keeps a commanded palm from its target, of those that one keeps."""
        found: dict[Side, str] = {}
        if not self._hand_goals or not self._own_links.pressures.any():
            return found
        for side, goal in self._hand_goals.items():
            jacobian = np.zeros((3, self._model.nv))
            mujoco.mj_jacSite(self._model, self.configuration.data, jacobian, None, self._palms[side])
            body = self._own_links.obstacle(self._arms[side], (goal - self._palm_positions[side]) @ jacobian)
            if body:
                found[side] = body
        return found

    def step(self, targets: BodyTargets) -> bool:
        """Move one control period toward the targets; return whether there was a solution within all limits."""
        self._body.aim(self.configuration.data, targets)
        self._hand_goals = targets.hands
        self.tasks = [self._body]
        for side, position in targets.hands.items():
            if goal := targets.palms.get(side):
                self._turned_hands[side].aim(self.configuration.data, goal)
                self.tasks.append(self._turned_hands[side])
            else:
                self._hand_places[side][:] = position
                self.tasks.append(self._hands[side])
        way = self._within_limits()
        self.solved = way is not None
        self._go(self._without_conditions() if way is None else way)
        return self.solved

    def _within_limits(self) -> Array | None:
        """Return the step within all limits, shape (nv,); None if there is none."""
        program, robot = self._program, self._robot
        program.aim(self.configuration, self.tasks)
        program.limit(self.configuration, self.limits, self._dt)
        _bound(
            program.low, program.high, self._qpos, self.lowest, robot.lower, robot.upper, self._farthest, self._dt
        )  # fmt: skip
        if self.still:
            dofs = np.add(self.still, BASE_DOFS)
            program.low[dofs] = program.high[dofs] = 0.0
        way = program.solve()
        if way is None and _asks_to_part(program, len(self._own_links.pressures)):
            way = program.solve()
        if way is None:
            return None
        self._own_links.pressures = program.pressures[: len(self._own_links.pressures)]
        return way

    def _without_conditions(self) -> Array:
        """Return the step of damped least squares within the bounds of each coordinate, shape (nv,).

        Arms go no further than own links stay apart. It is zero if even that has no solution.
        """
        program, pairs = self._program, len(self._own_links.pressures)
        program.aim(self.configuration, self.tasks)
        way = _least_squares(program)
        rows, arms = program.rows[:pairs], np.where(self._of_arms, way, 0.0)
        nearer, room = rows @ arms, np.maximum(program.rooms[:pairs] - rows @ (way - arms), 0.0)
        too_near = nearer > room
        if too_near.any():
            way -= (1.0 - (room[too_near] / nearer[too_near]).min()) * arms
        return way

    def _go(self, way: Array) -> None:
        """Go a step, shape (nv,), in a control period."""
        velocity = np.empty(len(way))
        self._move(velocity, way, self.velocity)
        self.velocity = velocity


def _place_of_target(task: mink.FrameTask) -> Array:
    """Give a task a target; return a view of its place, shape (3,): a new one each time takes as long as the task."""
    task.set_target(mink.SE3.identity())
    place: Array = task.transform_target_to_world.translation()
    return place


@compiled("void(f8[::1], f8[::1], f8[::1], f8, f8[::1], f8[::1], f8[::1], f8)")
def _bound(
    low: Array, high: Array, qpos: Array, lowest: float, lower: Array, upper: Array, farthest: Array, dt: float
) -> None:
    """Write how far joints may go, and the base may sink, in a control period.

    Args:
        low, high: bounds of a step, shape (nv,); are written.
        qpos: where it begins, shape (7 + nj,).
        lowest: as :class:`InverseKinematics` has it [m].
        lower, upper: limits of the joints, shape (nj,) [rad].
        farthest: how far each goes at its speed, shape (nj,) [rad].
        dt: [s].
    """
    room = max(0.0, qpos[_HEIGHT] - lowest)
    low[_HEIGHT] = -min(room * min(1.0, dt / _SINK_BRAKE_TIME), _RISE_SPEED * dt)
    braked = min(1.0, dt / _BRAKE_TIME)
    for joint in range(len(farthest)):
        now, most = qpos[BASE_COORDINATES + joint], farthest[joint]
        low[BASE_DOFS + joint] = max(braked * (lower[joint] - now), -most)
        high[BASE_DOFS + joint] = min(braked * (upper[joint] - now), most)


@bindable(
    "void(f8[::1], f8[::1], f8[::1])",
    "f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8, f8, i8, i8, f8[::1], f8[::1], f8[::1]",
)
def _go(
    velocity: Array,
    way: Array,
    before: Array,
    acceleration: Array,
    momentum_rate: Array,
    momentum: Array,
    quickest: Array,
    smooth: Array,
    smooth_momentum: float,
    dt: float,
    model: int,
    data: int,
    qpos: Array,
    speed: Array,
    spin: Array,
) -> None:
    """Go a step, and bring acceleration and momentum of the planned motion up to date.

    Args:
        velocity: of the motion, shape (nv,); is written.
        way: the step, shape (nv,).
        before: the velocity a control period ago, shape (nv,).
        acceleration, momentum_rate: smoothed, shapes (nv,) and (3,); are changed.
        momentum: a control period ago, shape (3,); becomes what it is now.
        quickest: limits of the acceleration, shape (nv,).
        smooth, smooth_momentum: shares by which both follow, shape (nv,), and one.
        dt: [s].
        model, data: addresses of MuJoCo's.
        qpos, speed, spin: of data: qpos, qvel, and the angular momentum that comes of them.
    """
    for dof in range(len(velocity)):
        velocity[dof] = way[dof] / dt
        rate = min(max((velocity[dof] - before[dof]) / dt, -quickest[dof]), quickest[dof])
        acceleration[dof] += smooth[dof] * (rate - acceleration[dof])
    integrate_pos(model, qpos.ctypes, velocity.ctypes, dt)
    kinematics(model, data)
    com_pos(model, data)
    speed[:] = velocity
    com_vel(model, data)
    subtree_vel(model, data)
    for axis in range(3):
        momentum_rate[axis] += smooth_momentum * ((spin[axis] - momentum[axis]) / dt - momentum_rate[axis])
        momentum[axis] = spin[axis]


def _least_squares(program: QuadraticProgram) -> Array:
    """Return the step that serves the tasks best within the bounds of each coordinate, shape (nv,); zero if none does.

    What would be beyond its bounds goes as far as it may, and the rest once more as well as it can.
    """
    way: Array = np.zeros(len(program.gradient))
    free = np.ones(len(way), dtype=bool)
    while free.any():
        try:
            rest = program.gradient[free] + program.hessian[np.ix_(free, ~free)] @ way[~free]
            way[free] = np.linalg.solve(program.hessian[np.ix_(free, free)], -rest)
        except np.linalg.LinAlgError:
            return np.zeros(len(free))
        if not np.isfinite(way).all():
            return np.zeros(len(free))
        within = clamp(way, program.low, program.high)
        if (within == way).all():
            break
        way, free = within, free & (within == way)
    return way


def _asks_to_part(program: QuadraticProgram, pairs: int) -> bool:
    """Make a goal of it, and no condition, that links that are too near part; return whether there are any.

    Args:
        program: its first conditions are those of pairs of links.
        pairs: how many.
    """
    rows, rooms = program.rows[:pairs], program.rooms[:pairs]
    parting = rooms < 0
    if not parting.any():
        return False
    program.hessian += _PARTING**2 * rows[parting].T @ rows[parting]
    program.gradient -= _PARTING**2 * rooms[parting] @ rows[parting]
    rooms[parting] = 0.0
    return True
