"""Whether a robot's hands reach ahead, and its eyes look there, in a trial."""

from __future__ import annotations

import math
from collections.abc import Iterator

import mujoco
import numpy as np

from humanoid_bt.checking.robot_trial import LAGS, SATURATED, Trial, drive_place
from humanoid_bt.control.body.own_links import OwnLinks, head_bodies
from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.messages import SIDES, Mode, Side
from humanoid_bt.core.texts import listed
from humanoid_bt.decision.robot_handle import RobotHandle

_REACH = 2.0  # s
_AHEAD = np.array([0.6, 0.0, -0.3])  # where its hands reach, from the shoulders, in lengths of the stretched arm
_OFF = 0.02  # m of a palm from there
_OUT_OF_VIEW = 0.7  # rad that what it looks at may be off the middle of its view: half of what a camera sees upright...
_HELD = 0.3  # rad, ...where an own link keeps its head from looking there
_AT_LIMIT = 0.02  # rad from a joint's limit
_BESIDE = 0.005  # m more than they must be apart, of links that keep each other from coming nearer


def reached(trial: Trial) -> Iterator[Problem]:
    """Let all hands reach ahead at once, and the eyes look there; yield what does not get there if it does not fall."""
    robot, skill = trial.robot, trial.skill
    trial.sense()
    shoulders = {side: skill.pose(f"{side}_shoulder").position for side in SIDES if skill.arm_length(side)}
    if not shoulders:
        return
    places = {side: place + skill.arm_length(side) * _AHEAD for side, place in shoulders.items()}
    middle, sees = np.mean([*places.values()], axis=0), "gaze" in robot.config.resources

    def ask(skill: RobotHandle) -> None:
        for side, place in places.items():
            skill.move_hand(side, place)
        if sees:
            skill.look_at(middle)

    if not trial.run(_REACH, ask):
        return
    trial.sense()
    state = skill.state
    if state.mode is not Mode.RUN:
        message = f"it stops as its hands reach ahead: {state.stop_reason}"
        hint = "look at the drives and the links of its arms"
        yield _warning(message, robot.config.place("hands"), hint, "does-not-reach")
        return
    for side in places:
        if trial.false_contacts.get(f"{side}_arm"):
            continue  # it yields, and that is told
        if (off := state.hand_errors.get(side, math.inf)) > _OFF:  # without one an arm yields
            yield _not_reached(trial, side, off)
    way = middle - state.gaze_position
    off = math.acos(max(-1.0, min(1.0, float(way @ state.gaze_direction) / float(np.linalg.norm(way)))))
    if sees and off > _HELD:
        yield from _not_looked(trial, off)


def _warning(message: str, place: Place, hint: str, code: str) -> Problem:
    return Problem(message, place, hint, code=code, severity="warning")


def _not_reached(trial: Trial, side: Side, off: float) -> Problem:
    """Return that a palm is too far from where it is to reach [m], at what is the most likely cause."""
    robot, skill = trial.robot, trial.skill
    length = skill.arm_length(side)
    message = f"{skill.why_no_nearer(side, off)} (to a place {_AHEAD[0] * length:.2f} m before its shoulder)"
    names = [*skill.arm_joints(side)]
    if side in skill.state.hand_obstacles:
        hint = "where shapes of links only seem to be so near: collision.capsules or collision.overlap"
        return _warning(message, robot.config.place("collision"), hint, "does-not-reach")
    lags = {name: _lag(trial, name) for name in names}
    worst = max(names, key=lags.__getitem__)
    if lags[worst] > LAGS:
        weak = trial.seen.saturated[robot.joint(worst)] > SATURATED * trial.seen.ticks
        key = "torque" if weak else "stiffness"
        hint = f"{worst!r} is {lags[worst]:.2f} rad from its setpoint: raise its {key}"
        return _warning(message, drive_place(robot, worst, key), hint, "does-not-reach")
    limited = listed([repr(name) for name in names if _is_at_limit(trial, name)])
    hint = f"at a limit of the model: {limited}; " if limited else ""
    hint += f"look at the body, the position and the drives of the {side} hand"
    return _warning(message, robot.config.place("hands", side), hint, "does-not-reach")


def _not_looked(trial: Trial, off: float) -> Iterator[Problem]:
    """Yield that the eyes point so far off what they are to look at [rad], at what is the most likely cause."""
    robot, neck = trial.robot, trial.robot.config.neck
    message = f"its eyes point {math.degrees(off):.0f} deg off where its hands reach"
    if near := _nearest_of_head(trial):
        head, other, distance = near
        message += f": {head!r} is kept {distance * 1000:.0f} mm from {other!r}"
        hint = "where their shapes only seem to be so near: collision.capsules or collision.overlap"
        yield _warning(message, robot.config.place("collision"), hint, "does-not-look")
    elif off > _OUT_OF_VIEW:
        limited = [repr(name) for name in (neck.yaw, neck.pitch) if _is_at_limit(trial, name)] if neck else []
        hint = f"at a limit of the model: {listed(limited)}; " if limited else ""
        hint += "look at the body of gaze, and at where it looks: ahead, down"
        yield _warning(message, robot.config.place("gaze"), hint, "does-not-look")


def _nearest_of_head(trial: Trial) -> tuple[str, str, float] | None:
    """Return a link of the head, another one that it may come no nearer to, and how far they are apart [m]."""
    head = head_bodies(trial.robot)
    if not head:
        return None
    state, links = trial.skill.state, OwnLinks(trial.robot, _BESIDE)
    model, data = links.model, mujoco.MjData(links.model)
    data.qpos[:] = np.concatenate([state.base_position, state.base_quaternion, state.joint_positions])
    mujoco.mj_kinematics(model, data)
    mujoco.mj_collision(model, data)
    for (one, other), distance in zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True):
        bodies = sorted((int(model.geom_bodyid[geom]) for geom in (one, other)), key=lambda body: body not in head)
        if distance < links.margins[one, other] + _BESIDE and bodies[0] in head and bodies[1] not in head:
            return model.body(bodies[0]).name, model.body(bodies[1]).name, distance
    return None


def _lag(trial: Trial, joint: str) -> float:
    """Return how far a joint is from its setpoint [rad]."""
    index, state = trial.robot.joint(joint), trial.skill.state
    return abs(float(state.setpoint_positions[index] - state.joint_positions[index]))


def _is_at_limit(trial: Trial, joint: str) -> bool:
    robot, index = trial.robot, trial.robot.joint(joint)
    angle = float(trial.skill.state.joint_positions[index])
    return bool(min(angle - robot.lower[index], robot.upper[index] - angle) < _AT_LIMIT)
