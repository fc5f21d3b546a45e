"""Whether a robot stands, reaches and walks: it is tried in simulation, as it would run, for a few seconds."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import mujoco
import numpy as np

from humanoid_bt.control.body.own_links import OwnLinks
from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.control.controller import Controller
from humanoid_bt.core.clock import DECISION_PERIOD, CycleClock, cycles
from humanoid_bt.core.errors import Place, Problem
from humanoid_bt.core.messages import SIDES, Array, Mode, Side
from humanoid_bt.core.texts import listed
from humanoid_bt.decision.robot import Robot, RobotHandle
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.scene import Scene
from humanoid_bt.plant.scene_config import SceneConfig
from humanoid_bt.robot.model import RobotModel, carriers

_STAND, _REACH, _WALK = 1.0, 2.0, 2.0  # s
_ARRIVE = 6.0  # s more for a learned walker that wanders
_GOAL = 2.0  # m ahead, farther than it gets in the first of these
_LEAST_WAY = 0.1  # m that it must have walked then
_DRIFT = 0.02  # m while it stands
_ASTRAY = 0.1  # m to the side, or rad, while it walks
_AHEAD = np.array([0.6, 0.0, -0.3])  # where its hands reach, from the shoulders, in lengths of the stretched arm
_OFF = 0.02  # m of a palm from there
_OUT_OF_VIEW = 0.7  # rad that what it looks at may be off the middle of its view: half of what a camera sees upright;
_HELD = 0.3  # rad, where an own link keeps its head from looking there
_AT_LIMIT = 0.02  # rad from a joint's limit
_BESIDE = 0.005  # m more than they must be apart, of links that keep each other from coming nearer
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
    """A robot in an empty scene, and one who commands it as a skill does.

    Attributes:
        robot: its model.
        skill: what commands it, and tells why that does not happen.
    """

    def __init__(self, robot: RobotModel) -> None:
        self.robot = robot
        self.plant = MujocoPlant(robot, Scene(SceneConfig(format=1, name="empty"), 0))
        self.plant.place(standing_posture(robot))
        self.controller = Controller(robot, self.plant)
        self._clock = CycleClock()
        self._decision = Robot(robot.config, self._clock, model=robot)
        self.skill = self._decision.handle("check", tuple(robot.config.resources))
        joints = len(robot.joint_names)
        self.seen = _Seen(np.zeros(joints), np.zeros(joints), np.zeros(joints))

    @property
    def fallen(self) -> bool:
        return self.controller.supervisor.mode is Mode.DAMP

    def run(self, duration: float, ask: Callable[[RobotHandle], None] | None = None) -> bool:
        """Run for a time [s], or until it falls; return whether it has not.

        Args:
            duration: [s].
            ask: what asks for something in every tick; it stands if None.
        """
        for _ in range(round(duration / DECISION_PERIOD)):
            self.sense()
            if ask:
                ask(self.skill)
            self.controller.submit(self._decision.commit())
            for _ in range(cycles(DECISION_PERIOD)):
                self.controller.run_cycle()
                self._clock.advance()
            if self.fallen:
                return False
            self._look(stands=ask is None)
        return True

    def sense(self) -> None:
        """Let the skill know how the robot is now."""
        self._decision.begin_tick(self.controller.state(), {})

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
    """Let the robot stand, reach and walk; return what is wrong.

    Raises:
        UserError: it cannot stand with flat feet.
    """
    trial = _Trial(robot)
    found = [*_stood(trial)]
    if not found:
        found += [*_reached(trial)]
    if not any(problem.severity == "error" for problem in found):
        found += [*_walked(trial)]
    return [*found, *_body_problems(trial)]


def _stood(trial: _Trial) -> Iterator[Problem]:
    body = trial.controller.body
    start = body.dynamics.com.copy()
    if not trial.run(_STAND):
        yield _fallen(trial, "as it stands", "does-not-stand")
        return
    drift = math.dist(body.dynamics.com[:2], start[:2])
    if drift > _DRIFT:
        message = f"it does not stand still: it moves {drift * 100:.0f} cm in {_STAND:g} s"
        yield _blamed(trial, message, "does-not-stand")


def _reached(trial: _Trial) -> Iterator[Problem]:
    """Let all hands reach ahead at once, and the eyes look there; yield what does not get there."""
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
        yield _fallen(trial, "as its hands reach ahead", "does-not-stand")
        return
    trial.sense()
    state = skill.state
    for side in places:
        if (off := state.hand_errors[side]) > _OFF:
            yield _not_reached(trial, side, off)
    way = middle - state.gaze_position
    off = math.acos(min(1.0, float(way @ state.gaze_direction) / float(np.linalg.norm(way))))
    if sees and off > _HELD:
        yield from _not_seen(trial, off)


def _not_reached(trial: _Trial, side: Side, off: float) -> Problem:
    """Return that a palm is too far from where it is to reach [m], at what is the most likely cause."""
    robot, skill = trial.robot, trial.skill
    length = skill.arm_length(side)
    message = f"{skill.why_no_nearer(side, off)}, to a place {abs(_AHEAD[0]) * length:.2f} m before its shoulder"
    names = [*skill.arm_joints(side)]
    if side in skill.state.hand_obstacles:
        hint = "where shapes of links only seem to be so near: collision.capsules or collision.overlap"
        return Problem(message, robot.config.place("collision"), hint, code="does-not-reach", severity="warning")
    lags = {name: _lag(trial, name) for name in names}
    worst = max(names, key=lags.__getitem__)
    if lags[worst] > _LAGS:
        weak = trial.seen.saturated[robot.joint(worst)] > _SATURATED * trial.seen.ticks
        key = "torque" if weak else "stiffness"
        hint = f"{worst!r} is {lags[worst]:.2f} rad from its setpoint: raise its {key}"
        return Problem(message, _drive_place(robot, worst, key), hint, code="does-not-reach", severity="warning")
    limited = listed([repr(name) for name in names if _is_at_limit(trial, name)])
    hint = f"at a limit of the model: {limited}; " if limited else ""
    hint += f"look at the body, the position and the drives of the {side} hand"
    return Problem(message, robot.config.place("hands", side), hint, code="does-not-reach", severity="warning")


def _not_seen(trial: _Trial, off: float) -> Iterator[Problem]:
    """Yield that the eyes point so far off what they are to look at [rad], at what is the most likely cause."""
    robot, neck = trial.robot, trial.robot.config.neck
    message = f"its eyes point {math.degrees(off):.0f} deg off where its hands reach"
    if near := _nearest_of_head(trial):
        head, other, distance = near
        message += f": {head!r} is kept {distance * 1000:.0f} mm from {other!r}"
        hint = "where their shapes only seem to be so near: collision.capsules or collision.overlap"
        yield Problem(message, robot.config.place("collision"), hint, code="does-not-look", severity="warning")
    elif off > _OUT_OF_VIEW:
        limited = [repr(name) for name in (neck.yaw, neck.pitch) if _is_at_limit(trial, name)] if neck else []
        hint = f"at a limit of the model: {listed(limited)}; " if limited else ""
        hint += "look at the body of gaze, and at where it looks: ahead, down"
        yield Problem(message, robot.config.place("gaze"), hint, code="does-not-look", severity="warning")


def _nearest_of_head(trial: _Trial) -> tuple[str, str, float] | None:
    """Return a link of the head, another one that it may come no nearer to, and how far they are apart [m]."""
    robot, state, links = trial.robot, trial.skill.state, OwnLinks(trial.robot, _BESIDE)
    if robot.config.neck is None:
        return None
    model, data = links.model, mujoco.MjData(links.model)
    data.qpos[:] = np.concatenate([state.base_position, state.base_quaternion, state.joint_positions])
    mujoco.mj_kinematics(model, data)
    mujoco.mj_collision(model, data)
    trunk = carriers(model, model.body(robot.config.torso).id)
    head = set(carriers(model, model.body(robot.config.gaze.body).id)).difference(trunk)
    for (one, other), distance in zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True):
        bodies = sorted((int(model.geom_bodyid[geom]) for geom in (one, other)), key=lambda body: body not in head)
        if distance < links.margins[one, other] + _BESIDE and bodies[0] in head and bodies[1] not in head:
            return model.body(bodies[0]).name, model.body(bodies[1]).name, distance
    return None


def _lag(trial: _Trial, joint: str) -> float:
    """Return how far a joint is from its setpoint [rad]."""
    index, state = trial.robot.joint(joint), trial.skill.state
    return abs(float(state.setpoint_positions[index] - state.joint_positions[index]))


def _is_at_limit(trial: _Trial, joint: str) -> bool:
    robot, index = trial.robot, trial.robot.joint(joint)
    angle = float(trial.skill.state.joint_positions[index])
    return bool(min(angle - robot.lower[index], robot.upper[index] - angle) < _AT_LIMIT)


def _walked(trial: _Trial) -> Iterator[Problem]:
    def ahead(skill: RobotHandle) -> None:
        skill.walk_to((_GOAL, 0.0), 0.0)

    if not trial.run(_WALK, ahead):
        yield _fallen(trial, "as it walks", "does-not-walk")
        return
    x, y, heading = (float(value) for value in trial.controller.state().stance)
    wanders = abs(y) > _ASTRAY or abs(heading) > _ASTRAY
    if trial.robot.policy and wanders and x >= _LEAST_WAY:  # it may wander as it begins, if it gets there
        if not trial.run(_ARRIVE, ahead):
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
