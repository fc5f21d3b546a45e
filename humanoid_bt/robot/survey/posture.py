"""A posture to stand in: knees bent, feet flat, arms hanging with the forearms a little ahead."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from humanoid_bt.core.messages import Array, Side
from humanoid_bt.robot.model import carriers
from humanoid_bt.robot.soft_limits import soft_limits
from humanoid_bt.robot.survey.limbs import Limb, Limbs, Surveyor, roles

_BEND = 0.35  # rad, of hips and ankles; knees twice as much
_INSIDE = 0.05  # rad that a home angle stays inside its limits
_ROUNDED = 2  # digits of an angle
# where an arm hangs, beside its shoulder, in lengths of the stretched arm: ahead, outward, up
_HAND, _ELBOW = np.array([0.28, 0.12, -0.86]), np.array([-0.08, 0.10, -0.48])
_SPREADS = (0.0, 0.08, 0.16, 0.24, 0.32)  # rad farther outward, until nothing is near the arms...
_CLEAR = 0.03  # ...by so much, m: they sway
_ELBOW_COUNTS, _REST_COUNTS = 0.5, 0.02  # beside the hand
_STEPS = 200
_TURNS = 10  # of an ankle, until...
_LEVEL = 0.05  # rad, ...a sole is flat: inverse kinematics does the rest


def home(
    surveyor: Surveyor, limbs: Limbs, palms: Mapping[Side, Array], soles: Mapping[Side, Array]
) -> dict[int, float]:
    """Return the angles of a posture to stand in, joint -> rad; what neither legs nor arms have is as the model rests.

    Args:
        surveyor: of the model.
        limbs: the robot's.
        palms: where they are in the frames of the hands, shape (3,) [m].
        soles: their axes in the frames of the feet, shape (3, 3).
    """
    legs: dict[int, float] = {}
    for side, leg in limbs.legs.items():
        legs |= _flat(surveyor, leg, soles[side][:, 2], _bent(surveyor, leg))
    angles = legs
    for spread in _SPREADS:
        angles = dict(legs)
        for side, arm in limbs.arms.items():
            angles |= _hanging(surveyor, side, arm, palms[side], spread)
        angles = {joint: round(angle, _ROUNDED) for joint, angle in angles.items()}
        if not _touches(surveyor, limbs, angles):
            break
    return angles | {joint: angle for joint, angle in _resting(surveyor).items() if joint not in angles}


def _resting(surveyor: Surveyor) -> dict[int, float]:
    """Return the angles of the reference posture, inside the joints' limits; what is 0 there stays 0."""
    model = surveyor.model
    hinges = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_HINGE]
    angles = {joint: _at_rest(model, joint) for joint in hinges}
    return {joint: round(_inside(model, joint, angle), _ROUNDED) if angle else 0.0 for joint, angle in angles.items()}


def overlapping(model: mujoco.MjModel, qpos: Array) -> dict[int, list[int]]:
    """Return the bodies that touch one that carries them, by that one.

    Args:
        model: of the robot alone.
        qpos: its posture, shape (nq,).
    """
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_forward(model, data)
    found: dict[int, list[int]] = {}
    bodies = np.sort(model.geom_bodyid[data.contact.geom[data.contact.dist < 0]], axis=1)
    for upper, lower in np.unique(bodies, axis=0).tolist():
        if upper in carriers(model, lower):
            found.setdefault(upper, []).append(lower)
    return found


def _touches(surveyor: Surveyor, limbs: Limbs, angles: Mapping[int, float]) -> bool:
    """Return whether an arm is near something else of the robot."""
    model, data = surveyor.model, mujoco.MjData(surveyor.model)
    for joint, angle in angles.items():
        data.qpos[model.jnt_qposadr[joint]] = angle
    margins = model.geom_margin.copy(), model.body_margin.copy()  # a body's bounds those of its geoms
    model.geom_margin[:] = model.body_margin[:] = _CLEAR / 2  # of two they add up
    mujoco.mj_forward(model, data)
    model.geom_margin[:], model.body_margin[:] = margins
    firsts = [int(model.jnt_bodyid[arm.joints[0]]) for arm in limbs.arms.values()]
    owners = [
        [next((first for first in firsts if first in carriers(model, int(model.geom_bodyid[g]))), 0) for g in pair]
        for pair in data.contact.geom.tolist()
    ]
    return any(one != other for one, other in owners)


def _bent(surveyor: Surveyor, leg: Limb) -> dict[int, float]:
    """Bend the first, second and last pitch joint of a leg so that the foot stays below the hip, and flat."""
    pitches = [j for j in leg.joints if surveyor.turns_about(j, 1)]
    if len(pitches) < 3:
        return {}
    bends = zip((pitches[0], pitches[1], pitches[-1]), (-_BEND, 2 * _BEND, -_BEND), strict=True)
    wanted = {joint: bend * float(np.sign(surveyor.axis(joint)[1])) for joint, bend in bends}
    share = min(_share(surveyor.model, joint, angle) for joint, angle in wanted.items())
    return {joint: _at_rest(surveyor.model, joint) + angle * share for joint, angle in wanted.items()}


def _flat(surveyor: Surveyor, leg: Limb, up: Array, angles: dict[int, float]) -> dict[int, float]:
    """Turn the ankle of a bent leg until its sole is flat, if it is not: feet of some models tilt at all zeros.

    Args:
        surveyor: of the model.
        leg: of it.
        up: what is up of its sole, in the frame of the foot, shape (3,).
        angles: joint -> rad.
    """
    model, data, angles = surveyor.model, mujoco.MjData(surveyor.model), dict(angles)
    ankles = [joint for role, joint in roles(surveyor, leg) if role.startswith("ankle")]
    for _ in range(_TURNS):
        for joint, angle in angles.items():
            data.qpos[model.jnt_qposadr[joint]] = angle
        mujoco.mj_kinematics(model, data)
        upright, tilted = data.xmat[surveyor.base].reshape(3, 3)[:, 2], data.xmat[leg.body].reshape(3, 3) @ up
        tilt = np.cross(tilted, upright)  # what it must turn about
        if np.linalg.norm(tilt) < _LEVEL or not ankles:
            break
        for joint, angle in zip(ankles, np.linalg.lstsq(data.xaxis[ankles].T, tilt)[0].tolist(), strict=True):
            angles[joint] = _inside(model, joint, angles.get(joint, _at_rest(model, joint)) + angle)
    return angles


def _share(model: mujoco.MjModel, joint: int, angle: float) -> float:
    """Return how much of an angle the limits of a joint allow that it turns from where it rests."""
    low, high = _limits(model, joint)
    return max(0.0, min(1.0, ((high if angle > 0 else low) - _at_rest(model, joint)) / angle))


def _hanging(surveyor: Surveyor, side: Side, arm: Limb, palm: Array, spread: float) -> dict[int, float]:
    """Move an arm, whatever the reference posture is, so that palm and elbow are where those of an arm hang."""
    model, data = surveyor.model, mujoco.MjData(surveyor.model)
    mujoco.mj_kinematics(model, data)
    bodies = [body for body in carriers(model, arm.body)[::-1] if body > arm.origin]
    points = np.array([*(data.xpos[body] for body in bodies), _point(data, arm.body, palm)])
    parts = np.linalg.norm(np.diff(points, axis=0), axis=1)
    length = float(parts.sum())
    outward = np.array([1.0, 1.0 if side == "left" else -1.0, 1.0])
    turn = data.xmat[surveyor.base].reshape(3, 3)
    ends = [(arm.body, palm, _HAND, 1.0)]
    if len(bodies) > 1:  # an arm of one link has no elbow
        elbow = bodies[1 + int(np.argmin(np.abs(np.cumsum(parts[:-1]) - length / 2)))]
        ends.append((elbow, np.zeros(3), _ELBOW, _ELBOW_COUNTS))
    goals = [points[0] + turn @ (_spread(goal, spread) * outward * length) for _, _, goal, _ in ends]
    dofs, places = model.jnt_dofadr[list(arm.joints)], model.jnt_qposadr[list(arm.joints)]
    low, high = np.array([_limits(model, joint) for joint in arm.joints]).T
    rest: Array = np.clip(model.qpos0[places], low, high)
    jacobian = np.zeros((3, model.nv))
    for _ in range(_STEPS):
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        hessian, gradient = _REST_COUNTS * np.eye(len(dofs)), _REST_COUNTS * (rest - data.qpos[places])
        for (body, offset, _, weight), goal in zip(ends, goals, strict=True):
            point = _point(data, body, offset)
            mujoco.mj_jac(model, data, jacobian, None, point, body)
            moved = jacobian[:, dofs] / length
            hessian = hessian + weight * moved.T @ moved
            gradient = gradient + weight * moved.T @ (goal - point) / length
        data.qpos[places] = np.clip(data.qpos[places] + 0.5 * np.linalg.solve(hessian, gradient), low, high)
    return {joint: float(data.qpos[place]) for joint, place in zip(arm.joints, places, strict=True)}


def _spread(goal: Array, angle: float) -> Array:
    """Return a place beside the shoulder, y outward, turned outward [rad]."""
    (x, y, z), cos, sin = goal, np.cos(angle), np.sin(angle)
    return np.array([x, cos * y - sin * z, cos * z + sin * y])


def _point(data: mujoco.MjData, body: int, offset: Array) -> Array:
    """Return a point of a body in the world, shape (3,) [m]."""
    return np.asarray(data.xpos[body] + data.xmat[body].reshape(3, 3) @ offset)


def _at_rest(model: mujoco.MjModel, joint: int) -> float:
    """Return a joint's angle in the reference posture, which is 0 if MJCF has no ``ref`` [rad]."""
    return float(model.qpos0[model.jnt_qposadr[joint]])


def _inside(model: mujoco.MjModel, joint: int, angle: float) -> float:
    """Return the home angle of a joint that is nearest to an angle [rad]."""
    low, high = _limits(model, joint)
    return min(max(angle, low), high)


def _limits(model: mujoco.MjModel, joint: int) -> tuple[float, float]:
    """Return between which angles a home angle may be [rad]."""
    (low,), (high,) = soft_limits(model, [joint], _INSIDE)
    return max(float(low), -np.pi), min(float(high), np.pi)
