"""Feedforward torques: gravity, planned acceleration and ground forces; tilt feedback; the ankles' limit."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.stabilizer import Load
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.control.jacobians import Indices, chains, point_moves
from humanoid_bt.core.compiled import compiled
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import BASE_DOFS, RobotModel

_UNLOADED = 1e-4  # share of the weight below which a foot counts as free
_ANKLE_LOADED = 0.02


class Feedforward:
    """Joint torques that carry the planned motion, so that the position gains only correct.

    tau = M qdd + h - sum J_i^T F_i (inverse dynamics with the wanted ground forces at the wanted centres of pressure).

    Args:
        robot: the robot.
        dynamics: its measured state.
    """

    def __init__(self, robot: RobotModel, dynamics: RobotDynamics) -> None:
        self._robot, self._dynamics = robot, dynamics
        config = robot.config
        self._gait = config.gait
        hips = [(side, config.legs[side].hip_roll, config.legs[side].hip_pitch) for side in SIDES]
        self._hips = {side: (robot.joint(roll), robot.joint(pitch)) for side, roll, pitch in hips}
        self._hip_turns = {side: (robot.direction(roll, 0), robot.direction(pitch, 1)) for side, roll, pitch in hips}
        feet = chains(robot.model, [robot.model.body(config.legs[side].sole.body).id for side in SIDES])
        self._feet: dict[Side, Indices] = dict(zip(SIDES, feet, strict=True))
        # pitch and roll of the ankles, -1 where there is none, and how far each may move the pressure along the sole:
        # half the margin more than is planned, which leaves the joint feedback some room
        legs = [(side, config.legs[side].ankle_pitch, config.legs[side].ankle_roll) for side in SIDES]
        self._ankles: dict[Side, Indices] = {
            side: np.array([robot.joint(pitch), -1 if roll is None else robot.joint(roll)])
            for side, pitch, roll in legs
        }
        sole = config.sole
        self._halves = np.array([sole.half_length, sole.half_width]) - 0.5 * np.array(sole.margins)
        self._jacobian = np.zeros((3, robot.model.nv))

    def torques(self, load: Load, acceleration: Array, position: Array, velocity: Array, lean: float = 0.0) -> Array:
        """Return feedforward torques, shape (nj,) [Nm].

        Args:
            load: how the feet shall carry the robot.
            acceleration: planned, shape (nv,).
            position, velocity: setpoint that the drives will get, shape (nj,).
            lean: of the pelvis ahead, as it is meant to be [rad].
        """
        dynamics, robot = self._dynamics, self._robot
        forces = dynamics.bias + dynamics.inertia_times(acceleration)
        carried = {side: load.share[side] * load.force for side in SIDES}
        for side in SIDES:
            if load.share[side] > _UNLOADED:
                _carry(
                    forces, carried[side], load.cop[side],
                    dynamics.motions, dynamics.origin, self._feet[side], self._jacobian,
                )  # fmt: skip
        torque: Array = forces[BASE_DOFS:]
        self._resist_tilt(torque, load, lean)
        for side in SIDES:
            if load.share[side] >= _ANKLE_LOADED:
                _limit_ankles(
                    torque, carried[side], dynamics.soles[side], self._ankles[side], self._halves,
                    position, velocity, robot.stiffness, robot.damping, dynamics.data.qpos, dynamics.data.qvel,
                    dynamics.motions, dynamics.origin, self._feet[side], self._jacobian,
                )  # fmt: skip
        return torque

    def _resist_tilt(self, torque: Array, load: Load, lean: float) -> None:
        gait, dynamics = self._gait, self._dynamics
        roll_rate, pitch_rate, _ = dynamics.gyro.tolist()
        roll = gait.tilt_stiffness * dynamics.roll + gait.tilt_damping * roll_rate
        pitch = gait.tilt_stiffness * (dynamics.pitch - lean) + gait.tilt_damping * pitch_rate
        for side in SIDES:
            hip_roll, hip_pitch = self._hips[side]
            roll_turns, pitch_turns = self._hip_turns[side]
            torque[hip_roll] += roll_turns * load.share[side] * roll
            torque[hip_pitch] += pitch_turns * load.share[side] * pitch


@compiled("void(f8[::1], f8[::1], f8[::1], f8[:, ::1], f8[::1], i8[::1], f8[:, ::1])")
def _carry(
    forces: Array, force: Array, place: Array, motions: Array, origin: Array, chain: Indices, jacobian: Array
) -> None:
    """Take from the generalised forces what a force of the ground on a foot does: J^T F.

    Args:
        forces: shape (nv,).
        force: on the foot, shape (3,) [N].
        place: where it acts on the ground, shape (2,) [m].
        motions, origin: of the dynamics.
        chain: the degrees of freedom that move the foot.
        jacobian: is written.
    """
    point_moves(motions, origin, (place[0], place[1], 0.0), chain, jacobian)
    for dof in chain:
        if dof < 0:
            break
        forces[dof] -= force[0] * jacobian[0, dof] + force[1] * jacobian[1, dof] + force[2] * jacobian[2, dof]


@compiled(
    "void(f8[::1], f8[::1], f8[::1], i8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1],"
    " f8[:, ::1], f8[::1], i8[::1], f8[:, ::1])"
)
def _limit_ankles(
    torque: Array,
    force: Array,
    sole: Array,
    ankles: Indices,
    halves: Array,
    position: Array,
    velocity: Array,
    stiffness: Array,
    damping: Array,
    qpos: Array,
    qvel: Array,
    motions: Array,
    origin: Array,
    chain: Indices,
    jacobian: Array,
) -> None:
    """Keep the whole ankle torque, feedback included, so small that the pressure stays inside the sole.

    Args:
        torque: of the joints, shape (nj,).
        force: on the foot, shape (3,) [N].
        sole: its pose, shape (3,).
        ankles: joints that move the pressure along the sole and across it, -1 for none.
        halves: how far they may, shape (2,) [m].
        position, velocity, stiffness, damping: that the drives will get.
        qpos, qvel: as they are.
        motions, origin: of the dynamics.
        chain: the degrees of freedom that move the foot.
        jacobian: is written.
    """
    base = len(qvel) - len(torque)
    fx, fy, fz = force[0], force[1], force[2]
    cos, sin = math.cos(sole[2]), math.sin(sole[2])
    point_moves(motions, origin, (sole[0], sole[1], 0.0), chain, jacobian)
    for axis in range(2):
        joint = ankles[axis]
        if joint < 0:
            continue
        dof = base + joint
        centred = -(jacobian[0, dof] * fx + jacobian[1, dof] * fy + jacobian[2, dof] * fz)  # pressure at its middle
        ex, ey = (cos, sin) if axis == 0 else (-sin, cos)
        tx, ty, tz = motions[dof, 0], motions[dof, 1], motions[dof, 2]
        reach = abs(halves[axis] * (tx * ey * fz - ty * ex * fz + tz * (ex * fy - ey * fx)))
        feedback = stiffness[joint] * (position[joint] - qpos[base + 1 + joint])
        feedback += damping[joint] * (velocity[joint] - qvel[dof])
        torque[joint] = min(max(feedback + torque[joint], centred - reach), centred + reach) - feedback
