"""The control layer's own copy of the robot: kinematics and dynamics of what it believes."""

from __future__ import annotations

import math

import mujoco
import numpy as np

from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.geometry import quaternion
from humanoid_bt.core.messages import SIDES, Array, Estimate, FootPose, Side
from humanoid_bt.robot.model import GAZE_SITE, RobotModel, palm_site, sole_site
from humanoid_bt.robot.mujoco_functions import (
    com_pos,
    com_vel,
    kinematics,
    make_m,
    mat_to_quat,
    mul_quat,
    passive,
    rne,
    subtree_vel,
)

GRAVITY = 9.81
"""[m/s^2]"""


class RobotDynamics:
    """Kinematics and dynamics of the estimated robot; everything in the world frame.

    Its arrays are the same ones always: whoever keeps what they say copies it.

    Args:
        robot: the robot.

    Attributes:
        model, data: MuJoCo's, of the robot alone.
        addresses: of these two.
        sides: those with a hand.
        com, com_velocity: shape (3,) [m], [m/s].
        sole_positions: of the (left, right) sole, shape (2, 3) [m].
        sole_headings: yaw of both, shape (2,) [rad].
        soles: poses (x, y, yaw) of the soles.
        footings: height of each sole and how its foot is turned from level about the world's x and y [m, rad].
        roll, pitch: tilt of the base [rad].
        bias: Coriolis, centrifugal and gravity forces, less those of the joints' springs, shape (nv,).
        motions, origin: as :func:`~humanoid_bt.control.jacobians.point_moves` wants them.
    """

    def __init__(self, robot: RobotModel) -> None:
        model = self.model = robot.bare
        data = self.data = mujoco.MjData(model)
        self._base = model.body(robot.config.base).id
        self._sole = {side: model.site(sole_site(side)).id for side in SIDES}
        self._palm = {side: model.site(palm_site(side)).id for side in robot.config.hands if side in SIDES}
        self._palm_places = {side: data.site_xpos[site] for side, site in self._palm.items()}  # views, as the next ones
        self._palm_axes = robot.palm_axes
        gaze = model.site(GAZE_SITE).id
        self._gaze, self._view = data.site_xpos[gaze], data.site_xmat[gaze, ::3]
        self.sides: tuple[Side, ...] = tuple(self._palm)
        self.addresses: tuple[int, int] = model._address, data._address
        self.bias: Array = data.qfrc_bias
        self.motions: Array = data.cdof
        self._qpos, self._qvel = data.qpos, data.qvel
        self._turns = data.site_xmat
        self.origin: Array = data.subtree_com[model.body_rootid[self._base]]
        rows: Array = np.zeros((8, 3))
        self.com: Array = rows[0]
        self.com_velocity: Array = rows[1]
        self.sole_positions: Array = rows[2:4]
        self.sole_headings: Array = rows[4:6, 2]
        self.soles: dict[Side, Array] = {"left": rows[4], "right": rows[5]}
        self.footings: dict[Side, Array] = {"left": rows[6], "right": rows[7]}
        self.roll = self.pitch = 0.0
        self._tilt: Array = np.zeros(2)
        self._update = _update.bind(
            rows, self._tilt, *self.addresses, data.qpos, self.bias, data.qfrc_spring,
            data.subtree_com[self._base], data.subtree_linvel[self._base], data.site_xpos, data.site_xmat,
            np.array(list(self._sole.values())), robot.config.feet_roll,
        )  # fmt: skip
        self._copy_sites = _copy_sites.bind(
            data.site_xpos, data.site_xmat, gaze, np.array(list(self._palm.values()), np.int64),
            np.array([quaternion(robot.palm_axes[side]) for side in self.sides]).reshape(-1, 4),
        )  # fmt: skip

    def update(self, estimate: Estimate) -> None:
        """Take over an estimate."""
        self._qpos[:], self._qvel[:] = estimate.qpos, estimate.qvel
        self._update()
        self.roll, self.pitch = self._tilt.tolist()

    @property
    def base_position(self) -> Array:
        """Position of the base, shape (3,)."""
        return np.array(self._qpos[:3])

    def sole_tilt(self, foot: int) -> Array:
        """Return how the (0: left, 1: right) sole is turned from level, rotation vector, world frame, shape (3,)."""
        _, roll, pitch = self.footings[SIDES[foot]].tolist()
        return np.array((roll, pitch, 0.0))

    def sole_velocity(self, foot: int) -> Array:
        """Return the velocity of the (0: left, 1: right) sole, world frame, shape (3,) [m/s]."""
        velocity, site = np.empty(6), self._sole[SIDES[foot]]
        mujoco.mj_objectVelocity(self.model, self.data, mujoco.mjtObj.mjOBJ_SITE, site, velocity, 0)
        return np.asarray(velocity[3:])

    def palm(self, side: Side) -> Array:
        """Return a palm's position, shape (3,)."""
        return np.array(self._palm_places[side])

    def palm_frame(self, side: Side) -> Array:
        """Return how a palm is turned: the rotation matrix of its frame, shape (3, 3)."""
        return np.asarray(self._turns[self._palm[side]].reshape(3, 3) @ self._palm_axes[side])

    @property
    def hands(self) -> dict[Side, Array]:
        """Palm positions of the hands that the robot has."""
        return {side: self.palm(side) for side in self.sides}

    @property
    def feet(self) -> dict[Side, FootPose]:
        """Poses of the soles."""
        places, headings = self.sole_positions.tolist(), self.sole_headings.tolist()
        return {side: FootPose(x, y, yaw, z) for side, (x, y, z), yaw in zip(SIDES, places, headings, strict=True)}

    @property
    def gaze_position(self) -> Array:
        """Position of the gaze site, shape (3,)."""
        return np.array(self._gaze)

    @property
    def gaze_direction(self) -> Array:
        """Direction of view, unit vector, shape (3,)."""
        return np.array(self._view)

    def copy_sites(self, points: Array, turns: Array) -> None:
        """Write where the eyes and the palms are, and how they are turned.

        Args:
            points: position of the gaze site, direction of view, palm positions, shape (2 + hands, 3).
            turns: how the palms' frames are turned, wxyz, shape (hands, 4).
        """
        self._copy_sites(points, turns)


@bindable("void(f8[:, ::1], f8[:, ::1])", "f8[:, ::1], f8[:, ::1], i8, i8[::1], f8[:, ::1]")
def _copy_sites(
    points: Array, turns: Array, places: Array, frames: Array, gaze: int, palms: Array, palm_turns: Array
) -> None:
    """See :meth:`RobotDynamics.copy_sites`.

    Args:
        points, turns: are written.
        places, frames: positions and rotation matrices of all sites, shapes (n, 3) and (n, 9).
        gaze, palms: which of these are meant.
        palm_turns: how the palms' frames are turned in their sites, wxyz, shape (hands, 4).
    """
    turn = np.empty(4)
    for i in range(3):
        points[0, i], points[1, i] = places[gaze, i], frames[gaze, 3 * i]
    for hand in range(len(palms)):
        points[2 + hand] = places[palms[hand]]
        mat_to_quat(turn.ctypes, frames[palms[hand]].ctypes)
        mul_quat(turns[hand].ctypes, turn.ctypes, palm_turns[hand].ctypes)


@bindable(
    "void()",
    "f8[:, ::1], f8[::1], i8, i8, f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[:, ::1], f8[:, ::1], i8[::1], b1",
)
def _update(
    rows: Array,
    tilt: Array,
    model: int,
    data: int,
    qpos: Array,
    bias: Array,
    springs: Array,
    com: Array,
    com_velocity: Array,
    places: Array,
    turns: Array,
    soles: Array,
    feet_roll: bool,
) -> None:
    """See :meth:`RobotDynamics.update`.

    A foot that no joint rolls leans sideways with its leg, on any ground: only its pitch counts for how the ground is
    turned from level.

    Args:
        rows: are written: centre of mass, its velocity, and of both soles positions, then poses, then footings.
        tilt: is written: roll and pitch of the base [rad].
        model, data: addresses of MuJoCo's.
        qpos, bias, springs, com, com_velocity: views of data; all but the first are written.
        places, turns: positions and rotation matrices of all sites, likewise, shapes (n, 3) and (n, 9).
        soles: which of these are soles.
        feet_roll: whether a joint rolls the feet.
    """
    kinematics(model, data)
    com_pos(model, data)
    make_m(model, data)
    com_vel(model, data)
    rne(model, data, 0, bias.ctypes)
    passive(model, data)
    bias -= springs
    subtree_vel(model, data)
    rows[0], rows[1] = com, com_velocity
    for foot in range(2):
        site, pose, footing = soles[foot], rows[4 + foot], rows[6 + foot]
        rows[2 + foot] = places[site]
        ahead, left, up_x, up_y = turns[site, 0], turns[site, 3], turns[site, 2], turns[site, 5]
        pose[0], pose[1], pose[2] = places[site, 0], places[site, 1], math.atan2(left, ahead)
        roll, pitch = -up_y, up_x
        if not feet_roll:
            length = math.hypot(ahead, left)
            across_x, across_y = -left / length, ahead / length
            about = across_y * up_x - across_x * up_y
            roll, pitch = about * across_x, about * across_y
        footing[0], footing[1], footing[2] = places[site, 2], roll, pitch
    w, x, y, z = qpos[3], qpos[4], qpos[5], qpos[6]
    tilt[0] = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    tilt[1] = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
