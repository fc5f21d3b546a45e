"""Angles of an arm at which its palm is as it shall be: inverse kinematics from many starts."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from humanoid_bt.control.body.palm_task import PalmTask
from humanoid_bt.control.body.self_collision import SelfCollisionLimit
from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import Array, HandTarget, Side
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel, carriers

_STARTS = 60  # that are tried
_LOOK = 10  # steps after which a start is given up that has not come nearer ...
_NEARER = 0.8  # ... than this share of where it was
_PLACE, _TURN = 0.005, 0.02  # m, rad from its target at which a palm is there
_BODY_DOES = 0.3  # m + rad of what is left where an arm ends that the rest of the body makes up for
_FARTHEST = 0.5  # m, rad that a step goes at most
_DAMPING = 0.1
_ROOM = 0.02  # rad that is left to the limits of joints, at most a quarter of their range


class ArmSearch:
    """Searches an arm's angles, a few steps in a control period; the rest of the body stays as it is.

    Each start goes by damped least squares (Nakamura, Hanafusa, "Inverse kinematic solutions with singularity
    robustness for robot manipulator control", 1986), the joints clamped into their limits. Starts are the angles as
    they are, the home posture, then random ones, the same every time.

    Args:
        robot: the robot.
        links: what keeps own links apart, in the model of which it searches.
        side: of the arm.

    Attributes:
        over: whether every start was tried, or none is wanted.
    """

    def __init__(self, robot: RobotModel, links: SelfCollisionLimit, side: Side) -> None:
        self._links, self._model = links, links.model
        self._data = mujoco.MjData(self._model)
        self._task = PalmTask(robot, self._model, side)
        joints = np.array(robot.arm_joints(side))
        self._places, self._dofs = joints + BASE_COORDINATES, joints + BASE_DOFS
        shoulder = int(self._model.jnt_bodyid[joints[0] + 1])
        self._arm = [body for body in range(self._model.nbody) if shoulder in carriers(self._model, body)]
        lower, upper = robot.lower[joints], robot.upper[joints]
        room = np.minimum(_ROOM, (upper - lower) / 4)
        self._lower, self._upper = lower + room, upper - room
        self._home = home = robot.home_qpos[self._places]
        self._drawn = (  # between these: a joint without limits is anywhere after one turn
            np.where(np.isfinite(lower), self._lower, home - math.pi),
            np.where(np.isfinite(upper), self._upper, home + math.pi),
        )
        self._goal: HandTarget | None = None
        self._starts, self._steps, self._off = 0, 0, math.inf
        self._best, self._least = self._home, _BODY_DOES
        self.over = True

    def begin(self, qpos: Array, goal: HandTarget) -> None:
        """Begin to search, with the body as in a configuration, shape (7 + nj,), for a goal in the world."""
        self._data.qpos[:] = qpos
        self._goal, self.over, self._starts, self._least = goal, False, 0, _BODY_DOES
        self._numbers = np.random.default_rng(0)
        self._start(qpos[self._places])

    def go_on(self, steps: int) -> Array | None:
        """Go on for some steps; return angles, shape (joints of the arm,) [rad], when there are some.

        Called again it goes on for others; :attr:`over` tells that there are no more.
        """
        for _ in range(steps):
            if self.over:
                return self._nearly()
            if (found := self._step()) is not None:
                self._restart()
                return found
        return None

    def _nearly(self) -> Array | None:
        """Return, once, the angles that came nearest, if the body can do the rest."""
        off, self._least = self._least, _BODY_DOES
        return self._best if off < _BODY_DOES else None

    def _step(self) -> Array | None:
        data, model, task = self._data, self._model, self._task
        assert self._goal is not None
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        task.aim(data, self._goal)
        counts = task.cost > 0
        error = np.where(counts, task.error, 0.0)
        place, turn = float(np.linalg.norm(error[:3])), float(np.linalg.norm(error[3:]))
        if place < _PLACE and turn < _TURN:
            if self._links.are_apart(data, self._arm):
                return np.array(data.qpos[self._places])
            self._restart()
            return None
        self._steps += 1
        if self._steps % _LOOK == 0:
            before, self._off = self._off, place + turn
            if self._off > _NEARER * before:
                if self._off < self._least and self._links.are_apart(data, self._arm):
                    self._best, self._least = np.array(data.qpos[self._places]), self._off
                self._restart()
                return None
        error = np.concatenate([_within(error[:3], place), _within(error[3:], turn)])
        jacobian = task.jacobian[:, self._dofs] * counts[:, None]
        pushed = np.linalg.solve(jacobian @ jacobian.T + _DAMPING**2 * np.eye(6), error)
        data.qpos[self._places] = clamp(data.qpos[self._places] + jacobian.T @ pushed, self._lower, self._upper)
        return None

    def _restart(self) -> None:
        self._starts += 1
        self.over = self._starts >= _STARTS
        self._start(self._home if self._starts == 1 else self._numbers.uniform(*self._drawn))

    def _start(self, angles: Array) -> None:
        self._data.qpos[self._places] = clamp(angles, self._lower, self._upper)
        self._steps, self._off = 0, math.inf


def _within(error: Array, length: float) -> Array:
    return error if length <= _FARTHEST else error * (_FARTHEST / length)
