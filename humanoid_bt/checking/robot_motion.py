"""Whether a robot stands, reaches and walks: it is tried in simulation, as it would run, for a few seconds."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from humanoid_bt.checking.robot_reach import reached
from humanoid_bt.checking.robot_trial import LAGS, SATURATED, Trial, drive_place
from humanoid_bt.control.body.guarded import GuardedBody
from humanoid_bt.control.body.own import own_body
from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.messages import SIDES
from humanoid_bt.core.texts import listed
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.files.class_files import class_place
from humanoid_bt.robot.model import RobotModel, carriers
from humanoid_bt.robot.policy.commands import impossible

_STAND = 1.0  # s
_WALK = 8  # s at most: a learned walker may wander as it begins
_WAY = 1.0  # m ahead
_DRIFT = 0.02  # m while it stands
_ASTRAY = 0.1  # m, and rad, from where it is to walk
_SAGS = 0.25  # rad that the load of standing would bend a joint whose feedforward does not know the load
_STRAINED = 0.5  # share of the time in which a drive may give all it has, even if the robot does not fall
_LEARNED = (
    "is all as in training: the order of joints and terms, scales, history, default_pose, action.scale, "
    "stiffness, damping, phase?"
)
_NOT_TOUCHED = (
    "are the masses of the model right, and is the noise of sensors.encoders not too large? "
    "Else raise the forces of contact"
)


def tried(robot: RobotModel) -> list[Problem]:
    """Let the robot stand, reach and walk; return what is wrong.

    Raises:
        UserError: it cannot stand with flat feet.
    """
    trial = Trial(robot)
    unused = [*_unused_body(trial)]
    found = _moved(trial)
    if trial.body_failed:  # what the robot does then, another body does
        body = trial.body
        place = class_place(type(body.guarded)) if isinstance(body, GuardedBody) else None
        found = [Problem(trial.body_failed, place or _policy_place(robot), code="failed-body")]
    return [*unused, *found]


def _policy_place(robot: RobotModel) -> Place | None:
    return robot.policy.place("model") if robot.policy else None


def _unused_body(trial: Trial) -> Iterator[Problem]:
    """Yield why a body of the user's own cannot be used that is there only for those who ask for it."""
    robot, controller = trial.robot, trial.controller
    if robot.config.body.own is None or robot.config.body.walk == "own":
        return
    try:
        own_body(robot, controller.body.dynamics, controller.estimator.contact).reset(controller.estimator.estimate)
    except UserError as error:
        yield from error.problems


def _moved(trial: Trial) -> list[Problem]:
    found = [*_stood(trial)]
    soft = [] if trial.fallen else [*_soft_drives(trial)]
    if not found:
        found += reached(trial)
        if trial.fallen:
            found.append(_fallen(trial, "as its hands reach ahead", "does-not-stand"))
        else:
            found += _walked(trial)
    return [*found, *soft, *_body_problems(trial)]


def _stood(trial: Trial) -> Iterator[Problem]:
    body = trial.controller.body
    for _ in range(2 if trial.robot.policy else 1):  # a learned walker takes its own posture first
        start = body.dynamics.com.copy()
        if not trial.run(_STAND):
            yield _fallen(trial, "as it stands", "does-not-stand")
            return
    drift = math.dist(body.dynamics.com[:2], start[:2])
    if drift > _DRIFT:
        message = f"it does not stand still: it moves {drift * 100:.0f} cm in {_STAND:g} s"
        yield _blamed(trial, message, "does-not-stand")


def _walked(trial: Trial) -> Iterator[Problem]:
    def ahead(skill: RobotHandle) -> None:
        skill.walk_to((_WAY, 0.0), 0.0)

    for _ in range(_WALK):
        if not trial.run(1.0, ahead):
            yield _fallen(trial, "as it walks", "does-not-walk")
            return
        if trial.controller.settled and not _astray(trial):
            return
    if _astray(trial):
        message = f"it does not walk {_WAY:g} m straight ahead: after {_WALK:g} s it is {_whereabouts(trial)}"
        if stopped := trial.controller.supervisor.reason:
            message = f"it stops as it walks: {stopped}"
        yield _blamed(trial, message, "does-not-walk", astray=not stopped)


def _astray(trial: Trial) -> bool:
    """Return whether it stands beside where it was to walk, or turned away."""
    x, y, heading = trial.controller.state().stance.tolist()
    return math.dist((x, y), (_WAY, 0.0)) > _ASTRAY or abs(heading) > _ASTRAY


def _whereabouts(trial: Trial) -> str:
    x, y, heading = trial.controller.state().stance.tolist()
    aside = f"{abs(y):.2f} m to the {'left' if y > 0 else 'right'}"
    return f"{x:.2f} m ahead and {aside}, turned by {math.degrees(heading):.0f} deg"


def _fallen(trial: Trial, when: str, code: str) -> Problem:
    stop = trial.controller.supervisor.stops[-1]
    return _blamed(trial, f"it falls {when}, after {stop.time:.1f} s: {stop.reason}", code)


def _blamed(trial: Trial, message: str, code: str, *, astray: bool = False) -> Problem:
    """Return a finding at what is the most likely cause; ``astray`` if it only gets elsewhere."""
    robot, seen = trial.robot, trial.seen
    if trial.false_contacts:
        return Problem(message, robot.config.place("contact"), f"nothing touches it: {_NOT_TOUCHED}", code=code)
    if robot.policy and astray and (ways := impossible(robot.policy.ranges)):
        hint = f"by the ranges of command it cannot {' or '.join(ways)}"
        return Problem(message, robot.policy.place("command"), hint, code=code)
    if robot.policy:
        return Problem(message, robot.policy.place("observation", "terms"), _LEARNED, code=code)
    legs = [i for i, name in enumerate(robot.joint_names) if _moves_a_foot(robot, name)]
    most = max(legs, key=lambda i: float(seen.saturated[i]))
    if seen.ticks and seen.saturated[most] > SATURATED * seen.ticks:
        name, limit = robot.joint_names[most], robot.torque_limit[most]
        hint = f"the drive of {name!r} gave all it has, {limit:g} Nm: raise its torque"
        return Problem(message, drive_place(robot, name, "torque"), hint, code=code)
    worst = max(legs, key=lambda i: float(seen.lag[i]))
    if seen.lag[worst] > LAGS:
        name = robot.joint_names[worst]
        now = f"now {robot.stiffness[worst]:g} Nm/rad"
        hint = f"{name!r} is {seen.lag[worst]:.2f} rad from its setpoint: raise its stiffness, {now}"
        return Problem(message, drive_place(robot, name, "stiffness"), hint, code=code)
    hint = "look at home, the soles, gait.stance_width, the legs' drives, and the masses of the model"
    return Problem(message, robot.config.place("legs"), hint, code=code)


def _soft_drives(trial: Trial) -> Iterator[Problem]:
    """Yield drives that did not hold their joints as the robot stood."""
    robot, seen = trial.robot, trial.seen
    sags = np.maximum(seen.lag, seen.held / robot.stiffness)
    if robot.policy:  # a learned walker drives them with gains of its own, and bends them on purpose
        sags[[robot.joint(robot.policy.joints[index]) for index in robot.policy.moves]] = 0.0
    told: set[Place] = set()
    for i in np.argsort(-sags):
        name, needed = robot.joint_names[i], seen.held[i] / _SAGS
        place = drive_place(robot, name, "stiffness")
        if sags[i] > _SAGS and place not in told:
            message = (
                f"the drive of {name!r} is too soft: as it stands, {seen.held[i]:.1f} Nm bend it {sags[i]:.1f} rad"
            )
            hint = f"at least {needed:.0f} Nm/rad are needed" if needed > robot.stiffness[i] else "raise its torque"
            yield Problem(message, place, hint, code="soft-drive")
            told.add(place)


def _body_problems(trial: Trial) -> Iterator[Problem]:
    """Yield drives that give all they have, and parts of the robot that touch each other."""
    robot, seen = trial.robot, trial.seen
    if trial.fallen:
        return
    if felt := [f"{group.replace('_', ' ')} ({force:.0f} N)" for group, force in trial.false_contacts.items()]:
        message = f"something seems to push its {listed(felt)}, and nothing does"
        yield Problem(message, robot.config.place("contact"), _NOT_TOUCHED, code="false-contact", severity="warning")
    told: set[Place] = set()
    for i in np.flatnonzero(seen.saturated > _STRAINED * seen.ticks):
        name, limit = robot.joint_names[i], robot.torque_limit[i]
        place = drive_place(robot, name, "torque")
        if place not in told:
            message = f"the drive of {name!r} gives all it has, {limit:g} Nm, most of the time"
            yield Problem(message, place, "raise its torque", code="weak-drive")
            told.add(place)
    for one, other in sorted(seen.touching):
        legs = {one, other} <= _legs(robot)
        hint = "a larger gait.stance_width or separation_min" if legs else "another home posture"
        posed = robot.policy.pose_place if robot.policy else robot.config.place("home")
        where = robot.config.place("gait", "stance_width") if legs else posed
        message, hint = (
            f"{one!r} and {other!r} touch each other",
            f"{hint}; or, if they only overlap: collision.overlap",
        )
        yield Problem(message, where, hint, code="self-contact", severity="warning")


def _moves_a_foot(robot: RobotModel, joint: str) -> bool:
    model = robot.model
    return model.body(int(model.jnt_bodyid[model.joint(joint).id])).name in _legs(robot)


def _legs(robot: RobotModel) -> set[str]:
    """Return the bodies of the legs."""
    model, config = robot.model, robot.config
    above = [carriers(model, model.body(config.legs[side].sole.body).id) for side in SIDES]
    return {model.body(body).name for bodies in above for body in bodies} - {config.base, "world"}
