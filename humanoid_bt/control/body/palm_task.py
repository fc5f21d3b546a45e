"""A palm that is turned, or that is held relative to the other one, as one task of mink's."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from humanoid_bt.control.body.rows_task import RowsTask
from humanoid_bt.core.geometry import quaternion, turn_between, turn_of_axis
from humanoid_bt.core.messages import Array, HandTarget, Pointing, Side
from humanoid_bt.core.palm import axis_of, other_side, turned_with
from humanoid_bt.robot.model import RobotModel, palm_site


class PalmTask(RowsTask):
    """Position of a palm, and its orientation or the direction of one of its axes.

    Its rows are those of resolved-rate control, as of the body's task. A direction has two degrees of freedom: the
    rows of an orientation, without what turns about the axis. Of two palms relative to each other the rows are those
    of the difference of their motions, so that neither lags behind the other, and the trunk has no part in it
    (Caccavale, Uchiyama, "Cooperative manipulation", in "Springer Handbook of Robotics", 2016, section 39.2).

    Args:
        robot: the robot.
        model: its model as the inverse kinematics has it.
        side: of the hand.

    Attributes:
        jacobian: shape (6, nv), world frame.
        error: from where it is to its target, shape (6,): position [m], rotation vector [rad].
    """

    def __init__(self, robot: RobotModel, model: mujoco.MjModel, side: Side) -> None:
        self._weights, self._model = robot.config.whole_body, model
        other = other_side(side)
        self._sites = {of: model.site(palm_site(of)).id for of in (side, other) if of in robot.palm_axes}
        self._axes: Mapping[Side, Array] = robot.palm_axes
        self._side, self._other = side, other
        super().__init__(6, model.nv)
        self._of_other = np.zeros((6, model.nv))
        self.cost[:3] = self._weights.hand

    def aim(self, data: mujoco.MjData, goal: HandTarget) -> None:
        """Take the goal of this control period, and how far the palm is from it now."""
        place, turn = self._at(data, self._side)
        mujoco.mj_jacSite(self._model, data, self.jacobian[:3], self.jacobian[3:], self._sites[self._side])
        position, orientation = goal.position, goal.orientation
        if goal.relative:
            origin, frame = self._at(data, self._other)
            arm = frame @ position
            position = origin + arm
            self._go_along(data, arm)
            orientation = turned_with(frame, orientation)
        self.error[:3] = position - place
        self.cost[3:] = 0.0 if orientation is None else self._weights.hand_orientation
        if isinstance(orientation, Pointing):
            axis = axis_of(turn, orientation.axis)
            self.error[3:] = turn_of_axis(axis, orientation.direction)
            self.jacobian[3:] -= np.outer(axis, axis @ self.jacobian[3:])
        elif orientation is not None:
            self.error[3:] = turn_between(quaternion(turn), orientation)

    @property
    def damping(self) -> float:
        """How much it damps now: less and less near the goal."""
        error = self.cost * self.error
        return self._weights.hand_damping * float(error.dot(error))

    def _at(self, data: mujoco.MjData, side: Side) -> tuple[Array, Array]:
        """Return place and frame of a palm, shape (3,) and (3, 3)."""
        site = self._sites[side]
        return data.site_xpos[site], data.site_xmat[site].reshape(3, 3) @ self._axes[side]

    def _go_along(self, data: mujoco.MjData, arm: Array) -> None:
        """Take from the rows how a point moves that the other palm carries: from its origin by ``arm``, world frame."""
        mujoco.mj_jacSite(self._model, data, self._of_other[:3], self._of_other[3:], self._sites[self._other])
        x, y, z = arm.tolist()
        across = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])  # a turn w moves the point by w x arm
        self.jacobian[:3] -= self._of_other[:3] + across @ self._of_other[3:]
        self.jacobian[3:] -= self._of_other[3:]
