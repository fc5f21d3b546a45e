"""Feedforward torques: gravity, planned acceleration and ground forces; tilt feedback; the ankles' limit."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.stabilizer import Load
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.control.jacobians import Indices, chains, point_moves
from humanoid_bt.core.bindable import bindable
from humanoid_bt.core.compiled import inlined
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.robot.model import BASE_DOFS, RobotModel
from humanoid_bt.robot.mujoco_functions import mul_m

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
        self._dynamics = dynamics
        config = robot.config
        legs = [config.legs[side] for side in SIDES]
        hips = np.array([[robot.joint(leg.hip_roll), robot.joint(leg.hip_pitch)] for leg in legs])
        turns = np.array([[robot.direction(leg.hip_roll, 0), robot.direction(leg.hip_pitch, 1)] for leg in legs], float)
        # pitch and roll of the ankles, -1 where there is none, and how far each may move the pressure along the sole:
        # half the margin more than is planned, which leaves the joint feedback some room
        ankles = np.array(
            [
                [robot.joint(leg.ankle_pitch), -1 if leg.ankle_roll is None else robot.joint(leg.ankle_roll)]
                for leg in legs
            ]
        )
        sole, data = config.sole, dynamics.data
        self._torques = _torques.bind(
            *dynamics.addresses, dynamics.bias, data.qpos, data.qvel, dynamics.motions, dynamics.origin,
            chains(robot.model, [robot.model.body(leg.sole.body).id for leg in legs]), hips, turns, ankles,
            np.array([sole.half_length, sole.half_width]) - 0.5 * np.array(sole.margins),
            robot.stiffness, robot.damping, config.gait.tilt_stiffness, config.gait.tilt_damping,
            np.zeros((3, robot.model.nv)),
        )  # fmt: skip
        self._size = robot.model.nv

    def torques(
        self,
        load: Load,
        acceleration: Array,
        position: Array,
        velocity: Array,
        tilt: tuple[float, float] = (0.0, 0.0),
    ) -> Array:
        """Return feedforward torques, shape (nj,) [Nm].

        Args:
            load: how the feet shall carry the robot.
            acceleration: planned, shape (nv,).
            position, velocity: setpoint that the drives will get, shape (nj,).
            tilt: roll and pitch of the pelvis as they are meant to be [rad].
        """
        dynamics, forces, (roll, pitch) = self._dynamics, np.empty(self._size), tilt
        self._torques(
            forces, acceleration, position, velocity, load.force, load.share, load.cop,
            dynamics.soles["left"], dynamics.soles["right"], dynamics.roll - roll, dynamics.pitch - pitch,
        )  # fmt: skip
        return forces[BASE_DOFS:]


@inlined
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


@inlined
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


@bindable(
    "void(f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[::1], f8[:, ::1], f8[::1], f8[::1], f8, f8)",
    "i8, i8, f8[::1], f8[::1], f8[::1], f8[:, ::1], f8[::1], i8[:, ::1], i8[:, ::1], f8[:, ::1], i8[:, ::1], f8[::1],"
    " f8[::1], f8[::1], f8, f8, f8[:, ::1]",
)
def _torques(
    forces: Array,
    acceleration: Array,
    position: Array,
    velocity: Array,
    force: Array,
    shares: Array,
    cops: Array,
    left_sole: Array,
    right_sole: Array,
    roll: float,
    pitch: float,
    model: int,
    data: int,
    bias: Array,
    qpos: Array,
    qvel: Array,
    motions: Array,
    origin: Array,
    chains: Indices,
    hips: Indices,
    turns: Array,
    ankles: Indices,
    halves: Array,
    stiffness: Array,
    damping: Array,
    tilt_stiffness: float,
    tilt_damping: float,
    jacobian: Array,
) -> None:
    """See :meth:`Feedforward.torques`.

    Args:
        forces: are written: those on the base, which nothing drives, and the torques of the joints, shape (nv,).
        acceleration, position, velocity: as there.
        force, shares, cops: of the load.
        left_sole, right_sole: poses, shape (3,).
        roll, pitch: how far the pelvis is tilted from how it is meant to be [rad].
        model, data: addresses of MuJoCo's.
        bias, qpos, qvel, motions, origin: of the dynamics.
        chains: the degrees of freedom that move each foot.
        hips, turns: roll and pitch of each hip: joints, and 1, or -1 if it turns the other way round, shape (2, 2).
        ankles: pitch and roll of each ankle, shape (2, 2).
        halves, stiffness, damping, jacobian: as :func:`_limit_ankles` wants them.
        tilt_stiffness, tilt_damping: with which both hips together resist a tilt [Nm/rad], [Nm s/rad].
    """
    mul_m(model, data, forces.ctypes, acceleration.ctypes)
    for dof in range(len(forces)):
        forces[dof] += bias[dof]
    torque = forces[len(forces) - len(position) :]
    for foot in range(2):
        share = shares[foot]
        if share > _UNLOADED:
            _carry(forces, share * force, cops[foot], motions, origin, chains[foot], jacobian)
    against_roll = tilt_stiffness * roll + tilt_damping * qvel[3]
    against_pitch = tilt_stiffness * pitch + tilt_damping * qvel[4]
    for foot in range(2):
        torque[hips[foot, 0]] += turns[foot, 0] * shares[foot] * against_roll
        torque[hips[foot, 1]] += turns[foot, 1] * shares[foot] * against_pitch
    for foot in range(2):
        share, sole = shares[foot], (left_sole if foot == 0 else right_sole)
        if share >= _ANKLE_LOADED:
            _limit_ankles(
                torque, share * force, sole, ankles[foot], halves, position, velocity, stiffness, damping,
                qpos, qvel, motions, origin, chains[foot], jacobian,
            )  # fmt: skip
