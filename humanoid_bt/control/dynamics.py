"""The control layer's own copy of the robot: kinematics and dynamics of what it believes."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.geometry import quaternion
from humanoid_bt.core.messages import SIDES, Array, Estimate, FootPose, Side
from humanoid_bt.robot.model import GAZE_SITE, RobotModel, palm_site, sole_site

GRAVITY = 9.81
"""[m/s^2]"""


class RobotDynamics:
    """Kinematics and dynamics of the estimated robot; everything in the world frame.

    Args:
        robot: the robot.

    Attributes:
        model, data: MuJoCo's, of the robot alone.
        com, com_velocity: shape (3,) [m], [m/s].
        sole_positions: of the (left, right) sole, shape (2, 3) [m].
        soles: poses (x, y, yaw) of the soles.
        footings: height of each sole and how its foot is turned from level about the world's x and y [m, rad].
        roll, pitch: tilt of the base [rad].
        bias: Coriolis, centrifugal and gravity forces, shape (nv,).
        motions, origin: as :func:`~humanoid_bt.control.jacobians.point_moves` wants them.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.model = robot.model
        self.data = mujoco.MjData(robot.model)
        self._base = robot.model.body(robot.config.base).id
        self._sole = {side: robot.model.site(sole_site(side)).id for side in SIDES}
        self._soles = np.array(list(self._sole.values()))
        self._places, self._turns = self.data.site_xpos, self.data.site_xmat  # views, of all sites
        self._palm = {side: robot.model.site(palm_site(side)).id for side in robot.config.hands if side in SIDES}
        self._palm_axes = robot.palm_axes
        self._palm_turns = {side: quaternion(axes) for side, axes in robot.palm_axes.items()}
        self._gaze = robot.model.site(GAZE_SITE).id
        self._feet_roll = robot.config.feet_roll
        self.bias: Array = self.data.qfrc_bias  # a view, as the next ones are
        self.motions: Array = self.data.cdof
        self._qpos, self._qvel = self.data.qpos, self.data.qvel
        self.origin: Array = self.data.subtree_com[self.model.body_rootid[self._base]]
        self.com: Array = np.zeros(3)
        self.com_velocity: Array = np.zeros(3)
        self.sole_positions: Array = np.zeros((2, 3))
        self.soles: dict[Side, Array] = {}
        self.footings: dict[Side, Array] = {}
        self.roll = self.pitch = 0.0
        self._product = np.zeros(robot.model.nv)

    def update(self, estimate: Estimate) -> None:
        """Take over an estimate."""
        model, data = self.model, self.data
        self._qpos[:], self._qvel[:] = estimate.qpos, estimate.qvel
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_rne(model, data, 0, self.bias)
        mujoco.mj_subtreeVel(model, data)
        self.com = data.subtree_com[self._base].copy()
        self.com_velocity = data.subtree_linvel[self._base].copy()
        self.sole_positions, poses, footings = np.empty((3, 2, 3))
        _look_at_soles(self._places, self._turns, self._soles, self._feet_roll, self.sole_positions, poses, footings)
        self.soles = dict(zip(SIDES, poses, strict=True))
        self.footings = dict(zip(SIDES, footings, strict=True))
        w, x, y, z = data.qpos[3:7].tolist()
        self.roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
        self.pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))

    @property
    def base_position(self) -> Array:
        """Position of the base, shape (3,)."""
        return np.array(self.data.qpos[:3])

    @property
    def gyro(self) -> Array:
        """Angular velocity of the base, base frame, shape (3,) [rad/s]."""
        return np.asarray(self.data.qvel[3:6])

    def sole_tilt(self, foot: int) -> Array:
        """Return how the (0: left, 1: right) sole is turned from level, rotation vector, world frame, shape (3,)."""
        _, roll, pitch = self.footings[SIDES[foot]].tolist()
        return np.array((roll, pitch, 0.0))

    def inertia_times(self, acceleration: Array) -> Array:
        """Return M(q) acceleration, shape (nv,); valid until the next call."""
        mujoco.mj_mulM(self.model, self.data, self._product, acceleration)
        return self._product

    def palm(self, side: Side) -> Array:
        """Return a palm's position, shape (3,)."""
        return np.array(self.data.site_xpos[self._palm[side]])

    def palm_frame(self, side: Side) -> Array:
        """Return how a palm is turned: the rotation matrix of its frame, shape (3, 3)."""
        return np.asarray(self.data.site_xmat[self._palm[side]].reshape(3, 3) @ self._palm_axes[side])

    @property
    def hand_orientations(self) -> dict[Side, Array]:
        """How the palms' frames are turned, wxyz, of the hands that the robot has."""
        found: dict[Side, Array] = {}
        for side, site in self._palm.items():
            found[side] = turn = np.empty(4)
            mujoco.mju_mat2Quat(turn, self.data.site_xmat[site])
            mujoco.mju_mulQuat(turn, turn.copy(), self._palm_turns[side])
        return found

    @property
    def hands(self) -> dict[Side, Array]:
        """Palm positions of the hands that the robot has."""
        return {side: self.palm(side) for side in self._palm}

    def foot_pose(self, side: Side) -> FootPose:
        """Return a sole's pose."""
        x, y, z = self.data.site_xpos[self._sole[side]].tolist()
        return FootPose(x, y, float(self.soles[side][2]), z)

    @property
    def gaze_position(self) -> Array:
        """Position of the gaze site, shape (3,)."""
        return np.array(self.data.site_xpos[self._gaze])

    @property
    def gaze_direction(self) -> Array:
        """Direction of view, unit vector, shape (3,)."""
        return np.array(self.data.site_xmat[self._gaze][[0, 3, 6]])


@compiled("void(f8[:, ::1], f8[:, ::1], i8[::1], b1, f8[:, ::1], f8[:, ::1], f8[:, ::1])")
def _look_at_soles(
    places: Array, turns: Array, soles: Array, feet_roll: bool, positions: Array, poses: Array, footings: Array
) -> None:
    """Write where soles are, and what each says of how the ground is turned from level.

    A foot that no joint rolls leans sideways with its leg, on any ground: only its pitch counts.

    Args:
        places, turns: positions and rotation matrices of all sites, shapes (n, 3) and (n, 9).
        soles: which of these are soles.
        feet_roll: whether a joint rolls them.
        positions: shape (2, 3) [m].
        poses: x, y, yaw, shape (2, 3) [m, rad].
        footings: height, and rotation vector from level about the world's x and y, shape (2, 3) [m, rad].
    """
    for foot in range(len(soles)):
        site = soles[foot]
        for axis in range(3):
            positions[foot, axis] = places[site, axis]
        ahead, left, up_x, up_y = turns[site, 0], turns[site, 3], turns[site, 2], turns[site, 5]
        poses[foot, 0], poses[foot, 1], poses[foot, 2] = places[site, 0], places[site, 1], math.atan2(left, ahead)
        roll, pitch = -up_y, up_x
        if not feet_roll:
            length = math.hypot(ahead, left)
            across_x, across_y = -left / length, ahead / length
            about = across_y * up_x - across_x * up_y
            roll, pitch = about * across_x, about * across_y
        footings[foot, 0], footings[foot, 1], footings[foot, 2] = places[site, 2], roll, pitch
