"""Feedforward torques: gravity, planned acceleration and ground forces; tilt feedback; the ankles' limit."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.control.body.stabilizer import Load
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel

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
        self._hips = {
            side: (robot.joint(config.legs[side].hip_roll), robot.joint(config.legs[side].hip_pitch)) for side in SIDES
        }
        # the ankles: joint, axis of the sole along which it moves the pressure, and how far it may:
        # half the margin more than is planned, which leaves the joint feedback some room
        half_length = config.sole.half_length - 0.5 * config.sole.margin
        half_width = config.sole.half_width - 0.5 * config.sole.margin
        self._ankles: dict[Side, list[tuple[int, int, float]]] = {}
        for side in SIDES:
            leg = config.legs[side]
            self._ankles[side] = [(robot.joint(leg.ankle_pitch), 0, half_length)]
            if leg.ankle_roll is not None:
                self._ankles[side].append((robot.joint(leg.ankle_roll), 1, half_width))
        self._linear = np.zeros((3, robot.model.nv))
        self._angular = np.zeros((3, robot.model.nv))

    def torques(self, load: Load, acceleration: Array, position: Array, velocity: Array, lean: float = 0.0) -> Array:
        """Return feedforward torques, shape (nj,) [Nm].

        Args:
            load: how the feet shall carry the robot.
            acceleration: planned, shape (nv,).
            position, velocity: setpoint that the drives will get, shape (nj,).
            lean: of the pelvis ahead, as it is meant to be [rad].
        """
        dynamics = self._dynamics
        forces = dynamics.bias + dynamics.inertia_times(acceleration)
        for side in SIDES:
            if load.share[side] > _UNLOADED:
                point = np.array([*load.cop[side].tolist(), 0.0])
                dynamics.foot_jacobian(side, point, self._linear)
                forces -= (load.share[side] * load.force).dot(self._linear)
        torque: Array = forces[BASE_DOFS:].copy()
        self._resist_tilt(torque, load, lean)
        for side in SIDES:
            if load.share[side] >= _ANKLE_LOADED:
                self._limit_ankle(torque, side, load.share[side] * load.force, position, velocity)
        return torque

    def _resist_tilt(self, torque: Array, load: Load, lean: float) -> None:
        gait, dynamics = self._gait, self._dynamics
        roll_rate, pitch_rate, _ = dynamics.gyro.tolist()
        roll = gait.tilt_stiffness * dynamics.roll + gait.tilt_damping * roll_rate
        pitch = gait.tilt_stiffness * (dynamics.pitch - lean) + gait.tilt_damping * pitch_rate
        for side in SIDES:
            hip_roll, hip_pitch = self._hips[side]
            torque[hip_roll] += load.share[side] * roll
            torque[hip_pitch] += load.share[side] * pitch

    def _limit_ankle(self, torque: Array, side: Side, force: Array, position: Array, velocity: Array) -> None:
        """Keep the whole ankle torque, feedback included, so small that the pressure stays inside the sole."""
        dynamics, robot = self._dynamics, self._robot
        x, y, yaw = dynamics.soles[side].tolist()
        fx, fy, fz = force.tolist()
        dynamics.foot_jacobian(side, np.array([x, y, 0.0]), self._linear, self._angular)
        cos, sin = math.cos(yaw), math.sin(yaw)
        for joint, axis, half in self._ankles[side]:
            dof = BASE_DOFS + joint
            lx, ly, lz = self._linear[:, dof].tolist()
            centred = -(lx * fx + ly * fy + lz * fz)  # torque for pressure at the sole's centre
            ex, ey = (cos, sin) if axis == 0 else (-sin, cos)
            tx, ty, tz = self._angular[:, dof].tolist()
            reach = abs(half * (tx * ey * fz - ty * ex * fz + tz * (ex * fy - ey * fx)))
            feedback = robot.stiffness.item(joint) * (
                position.item(joint) - dynamics.data.qpos.item(BASE_COORDINATES + joint)
            ) + robot.damping.item(joint) * (velocity.item(joint) - dynamics.data.qvel.item(dof))
            whole = min(max(feedback + torque.item(joint), centred - reach), centred + reach)
            torque[joint] = whole - feedback
