"""Whether a robot stands and walks: it is tried in simulation, as it would run, for a few seconds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.clock import DECISION_PERIOD, SERVO_PERIOD, cycles
from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.messages import SIDES, Array, BaseTarget, Command, Mode, Target
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.model import RobotModel, carriers

_STAND, _WALK = 1.0, 2.0  # s
_ARRIVE = 6.0  # s more for a learned walker that wanders
_GOAL = 2.0  # m ahead, farther than it gets in the first of these
_LEAST_WAY = 0.1  # m that it must have walked then
_DRIFT = 0.02  # m while it stands
_ASTRAY = 0.1  # m to the side, or rad, while it walks
_LAGS = 0.15  # rad of a standing joint from its setpoint
_SAGS = 0.25  # rad that the load of standing would bend a joint whose feedforward does not know the load
_STRAINED = 0.5  # share of the time in which a drive may give all it has, even if the robot does not fall
_LEARNED = (
    "is all as in training: the order of joints and terms, scales, history, default_pose, action.scale, "
    "stiffness, damping, phase?"
)
_SATURATED = 0.1  # share of the time at its torque limit from which a drive counts as too weak


@dataclass
class _Seen:
    """What was noticed so far.

    Attributes:
        lag: the joints' largest distance from their setpoints while it stood, shape (nj,) [rad].
        held: torque of each joint as it stood, shape (nj,) [Nm].
        saturated: servo ticks of each joint with all the torque that its drive has, shape (nj,).
        ticks: how many there were.
        touching: pairs of bodies of the robot that touched each other.
    """

    lag: Array
    held: Array
    saturated: Array
    ticks: int = 0
    touching: set[tuple[str, str]] = field(default_factory=set)


class _Trial:
    """A robot in an empty scene."""

    def __init__(self, robot: RobotModel) -> None:
        self.robot = robot
        self.plant = MujocoPlant(robot, Scene(SceneConfig(format=1, name="empty"), 0))
        self.plant.place(standing_posture(robot))
        self.controller = Controller(robot, self.plant)
        joints = len(robot.joint_names)
        self.seen = _Seen(np.zeros(joints), np.zeros(joints), np.zeros(joints))

    @property
    def fallen(self) -> bool:
        return self.controller.supervisor.mode is Mode.DAMP

    def run(self, duration: float, targets: dict[str, Target]) -> bool:
        """Run for a time [s], or until it falls; return whether it has not."""
        for _ in range(round(duration / DECISION_PERIOD)):
            now = self.controller.cycle * SERVO_PERIOD
            self.controller.submit(Command(self.controller.cycle, now, targets))
            for _ in range(cycles(DECISION_PERIOD)):
                self.controller.run_cycle()
            if self.fallen:
                return False
            self._look(stands=not targets)
        return True

    def _look(self, stands: bool) -> None:
        seen, measured = self.seen, self.plant.measure()
        seen.ticks += 1
        seen.saturated += np.abs(measured.joint_torque) >= self.robot.torque_limit
        if stands:
            off = np.abs(self.controller.servo.command.position - measured.joint_position)
            seen.lag, seen.held = np.maximum(seen.lag, off), np.abs(measured.joint_torque)
        model, data = self.plant.model, self.plant.data
        robot_bodies = self.robot.model.nbody
        for contact in data.contact[: data.ncon]:
            pair = sorted(int(model.geom_bodyid[geom]) for geom in contact.geom)
            if pair[0] > 0 and pair[1] < robot_bodies and contact.dist < 0:
                seen.touching.add((model.body(pair[0]).name, model.body(pair[1]).name))


def tried(robot: RobotModel) -> list[Problem]:
    """Let the robot stand and walk; return what is wrong.

    Raises:
        UserError: it cannot stand with flat feet.
    """
    trial = _Trial(robot)
    return [*_stood_and_walked(trial), *_body_problems(trial)]


def _stood_and_walked(trial: _Trial) -> Iterator[Problem]:
    body = trial.controller.body
    start = body.dynamics.com.copy()
    if not trial.run(_STAND, {}):
        yield _fallen(trial, "as it stands", "does-not-stand")
        return
    drift = math.dist(body.dynamics.com[:2], start[:2])
    if drift > _DRIFT:
        message = f"it does not stand still: it moves {drift * 100:.0f} cm in {_STAND:g} s"
        yield _blamed(trial, message, "does-not-stand")
        return
    ahead = {"base": BaseTarget(np.array([_GOAL, 0.0]), 0.0)}
    if not trial.run(_WALK, dict(ahead)):
        yield _fallen(trial, "as it walks", "does-not-walk")
        return
    x, y, heading = (float(value) for value in trial.controller.state().stance)
    wanders = abs(y) > _ASTRAY or abs(heading) > _ASTRAY
    if trial.robot.policy and wanders and x >= _LEAST_WAY:  # it may wander as it begins, if it gets there
        if not trial.run(_ARRIVE, dict(ahead)):
            yield _fallen(trial, "as it walks", "does-not-walk")
            return
        x, y, heading = (float(value) for value in trial.controller.state().stance)
        if math.dist((x, y), (_GOAL, 0)) > _ASTRAY or abs(heading) > _ASTRAY:
            message = f"it does not get to {_GOAL:g} m straight ahead: after {_WALK + _ARRIVE:g} s it is"
            yield _blamed(trial, f"{message} {_whereabouts(x, y, heading)}", "does-not-walk")
    elif x < _LEAST_WAY or wanders:
        message = f"it does not walk straight ahead: after {_WALK:g} s it is {_whereabouts(x, y, heading)}"
        yield _blamed(trial, message, "does-not-walk")


def _whereabouts(x: float, y: float, heading: float) -> str:
    aside = f"{abs(y):.2f} m to the {'left' if y > 0 else 'right'}"
    return f"{x:.2f} m ahead and {aside}, turned by {math.degrees(heading):.0f} deg"


def _fallen(trial: _Trial, when: str, code: str) -> Problem:
    stop = trial.controller.supervisor.stops[-1]
    return _blamed(trial, f"it falls {when}, after {stop.time:.1f} s: {stop.reason}", code)


def _blamed(trial: _Trial, message: str, code: str) -> Problem:
    """Return a finding at what is the most likely cause."""
    robot, seen = trial.robot, trial.seen
    if robot.policy:
        return Problem(message, robot.policy.place("observation", "terms"), _LEARNED, code=code)
    legs = [i for i, name in enumerate(robot.joint_names) if _moves_a_foot(robot, name)]
    most = max(legs, key=lambda i: float(seen.saturated[i]))
    if seen.ticks and seen.saturated[most] > _SATURATED * seen.ticks:
        name, limit = robot.joint_names[most], robot.torque_limit[most]
        hint = f"the drive of {name!r} gave all it has, {limit:g} Nm: raise its torque"
        return Problem(message, _drive_place(robot, name, "torque"), hint, code=code)
    worst = max(legs, key=lambda i: float(seen.lag[i]))
    if seen.lag[worst] > _LAGS:
        name = robot.joint_names[worst]
        now = f"now {robot.stiffness[worst]:g} Nm/rad"
        hint = f"{name!r} is {seen.lag[worst]:.2f} rad from its setpoint: raise its stiffness, {now}"
        return Problem(message, _drive_place(robot, name, "stiffness"), hint, code=code)
    hint = "look at home, the soles, gait.stance_width, the legs' drives, and the masses of the model"
    return Problem(message, robot.config.place("legs"), hint, code=code)


def _body_problems(trial: _Trial) -> Iterator[Problem]:
    """Yield drives that do not hold their joints, and parts of the robot that touch each other."""
    robot, seen = trial.robot, trial.seen
    if trial.fallen:
        return
    sags = np.maximum(seen.lag, seen.held / robot.stiffness)
    if robot.policy:  # a learned walker drives them with gains of its own, and bends them on purpose
        sags[[robot.joint(robot.policy.joints[index]) for index in robot.policy.moves]] = 0.0
    told: set[Place] = set()
    for i in np.argsort(-sags):
        name, needed = robot.joint_names[i], seen.held[i] / _SAGS
        place = _drive_place(robot, name, "stiffness")
        if sags[i] > _SAGS and place not in told:
            message = (
                f"the drive of {name!r} is too soft: as it stands, {seen.held[i]:.1f} Nm bend it {sags[i]:.1f} rad"
            )
            hint = f"at least {needed:.0f} Nm/rad are needed" if needed > robot.stiffness[i] else "raise its torque"
            yield Problem(message, place, hint, code="soft-drive")
            told.add(place)
    for i in np.flatnonzero(seen.saturated > _STRAINED * seen.ticks):
        name, limit = robot.joint_names[i], robot.torque_limit[i]
        place = _drive_place(robot, name, "torque")
        if place not in told:
            message = f"the drive of {name!r} gives all it has, {limit:g} Nm, most of the time"
            yield Problem(message, place, "raise its torque", code="weak-drive")
            told.add(place)
    for one, other in sorted(seen.touching):
        legs = {one, other} <= _legs(robot)
        hint = "a larger gait.stance_width or separation_min" if legs else "another home posture"
        place = robot.config.place("gait", "stance_width") if legs else robot.config.place("home")
        message, hint = (
            f"{one!r} and {other!r} touch each other",
            f"{hint}; or, if they only overlap: collision.overlap",
        )
        yield Problem(message, place, hint, code="self-contact", severity="warning")


def _moves_a_foot(robot: RobotModel, joint: str) -> bool:
    model = robot.model
    return model.body(int(model.jnt_bodyid[model.joint(joint).id])).name in _legs(robot)


def _legs(robot: RobotModel) -> set[str]:
    """Return the bodies of the legs."""
    model, config = robot.model, robot.config
    above = [carriers(model, model.body(config.legs[side].sole.body).id) for side in SIDES]
    return {model.body(body).name for bodies in above for body in bodies} - {config.base, "world"}


def _drive_place(robot: RobotModel, joint: str, key: str) -> Place:
    drive = robot.config.drive(joint)
    index = next(i for i, each in enumerate(robot.config.drives) if each is drive)
    return robot.config.place("drives", index, key)
