"""A robot compiled from its MJCF model and ``robot.yaml``: drives, sites and sensors are added, nothing is edited."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from humanoid_bt.core.errors import Place, Problem, UserError, nearest, relative
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.core.patterns import matching
from humanoid_bt.files.reading import is_file
from humanoid_bt.robot.config import FrameConfig, RobotConfig, SiteConfig
from humanoid_bt.robot.overruled import overruled
from humanoid_bt.robot.palm import palm_axes
from humanoid_bt.robot.policy.policy import Policy, load_policy
from humanoid_bt.robot.published import PLAIN, model_problems, read_model
from humanoid_bt.robot.soft_limits import soft_limits

BASE_DOFS = 6
BASE_COORDINATES = 7


def sole_site(side: str) -> str:
    """Return the name of a sole's site."""
    return f"hbt_{side}_sole"


def palm_site(side: str) -> str:
    """Return the name of a palm's site."""
    return f"hbt_{side}_palm"


GAZE_SITE = "hbt_gaze"


def carriers(model: mujoco.MjModel, body: int) -> list[int]:
    """Return a body and those that carry it, up to the world."""
    above = [body]
    while above[-1] != 0:
        above.append(int(model.body_parentid[above[-1]]))
    return above


def foot_sensor(side: str) -> str:
    """Return the name of the contact-force sensor of a foot."""
    return f"hbt_{side}_foot_force"


_FORCE = 1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE)
_LEAST = 1e-6  # m, length of a direction
_DRIVES_OWN = 0.5  # of the damping of a drive, from which that of its joint counts as one of a drive, ...
LEAST_DAMPING = 1.0  # Nm s/rad, ...if it is more than a finger's
_ALIKE = 0.9  # cosine of two directions of which one does not say how a body is turned about the other
_NET = 3  # what a contact sensor makes of several contacts: their sum, in the world frame


class RobotModel:
    """A robot and its numbers as arrays over its joints, in the model's joint order.

    Args:
        config: what ``robot.yaml`` says.

    Raises:
        UserError: the MJCF file is not valid, or ``robot.yaml`` names what it does not have; or its learned walker
            does not fit.

    Attributes:
        policy: the learned walker that walks it; None if none does.
        model: the robot alone, without floor or scene.
        bare: the same without what is only drawn, for control: everything but the geoms has the same place and number.
        joint_names: names of the nj joints; joint i is coordinate 7 + i and degree of freedom 6 + i.
        lower, upper: soft limits, shape (nj,) [rad]; infinite where the model has none.
        stiffness, damping: drive gains, shape (nj,) [Nm/rad], [Nm s/rad].
        torque_limit: shape (nj,) [Nm].
        speed_limit: shape (nj,) [rad/s].
        home_qpos: home posture above the origin, feet not yet on the ground, shape (7 + nj,).
        axes: of the joints in the home posture, in the frame of the base (x ahead, z up), shape (nj, 3).
        mass: [kg].
        palm_axes: of each hand the rotation from its palm's frame (x along the fingers, z where the palm faces) to that
            of its body, shape (3, 3).
    """

    def __init__(self, config: RobotConfig) -> None:
        self.policy = learned_walker(config)
        self.config = config
        spec = self.spec()
        model = self.model = _compile(spec, config)
        spec.compiler.discardvisual = True
        self.bare = _compile(spec, config)
        self.joint_names = tuple(model.joint(j).name for j in range(1, model.njnt))
        if self.policy and (problems := list(self.policy.problems_with(self.joint_names))):
            raise UserError(problems)
        if problems := list(_overruled(config, self.joint_names)):
            raise UserError(problems)
        self.config = config = _standing_as_learned(config, self.policy)
        drives = [config.drive(name) for name in self.joint_names]
        self.stiffness = np.array([drive.stiffness for drive in drives if drive])
        self.damping = np.array([drive.damping for drive in drives if drive])
        self.torque_limit = np.array([drive.torque for drive in drives if drive])
        self.speed_limit = np.array([drive.speed for drive in drives if drive])
        self.lower, self.upper = soft_limits(model, list(range(1, model.njnt)), config.soft_limit_margin)
        home = np.array([config.home_angle(name) for name in self.joint_names])
        self.home_qpos: Array = np.concatenate([model.qpos0[:BASE_COORDINATES], np.clip(home, self.lower, self.upper)])
        self.axes = self._axes_at_home()
        if problems := list(self._hands_without_arms()):
            raise UserError(problems)
        if self.policy and (problems := list(self._lent_in_vain(self.policy))):
            raise UserError(problems)
        self.palm_axes: dict[Side, Array] = {side: palm_axes(config, side) for side in SIDES if side in config.hands}
        self.mass = float(model.body_subtreemass[model.body(config.base).id])

    def joint(self, name: str) -> int:
        """Return a joint's index in the arrays over joints."""
        return self.joint_names.index(name)

    def direction(self, name: str, axis: int) -> float:
        """Return which way round a joint turns about an axis (0: x, 1: y, 2: z) of the base as it stands: 1 or -1."""
        return -1.0 if self.axes[self.joint(name), axis] < 0 else 1.0

    def _axes_at_home(self) -> Array:
        data = mujoco.MjData(self.model)
        data.qpos[:] = self.home_qpos
        mujoco.mj_kinematics(self.model, data)
        return np.asarray(data.xaxis[1:] @ data.body(self.config.base).xmat.reshape(3, 3))

    def arm_joints(self, side: Side) -> list[int]:
        """Return the joints between the torso and a hand, as indices of the arrays over joints; none without hands."""
        model, config = self.model, self.config
        if side not in config.hands:
            return []
        trunk = carriers(model, model.body(config.torso).id)
        arm = set(carriers(model, model.body(config.hands[side].body).id)) - set(trunk)
        return [j - 1 for j in range(1, model.njnt) if int(model.jnt_bodyid[j]) in arm]

    def _hands_without_arms(self) -> Iterator[Problem]:
        torso, hands = self.config.torso, self.config.hands
        for side in SIDES:
            if side in hands and not self.arm_joints(side):
                message = f"no joint moves the {side} hand, on {hands[side].body!r}, against the torso, {torso!r}"
                hint = "a hand is on the last link of an arm; a robot without arms has no key 'hands'"
                yield Problem(message, self.config.place("hands", side, "body"), hint, code="wrong-torso")

    def _lent_in_vain(self, policy: Policy) -> Iterator[Problem]:
        """Yield what a learned walker is to lend that hands and gaze could do nothing with, or that it stands on."""
        model, config, names, lend = self.model, self.config, self.joint_names, policy.config.lend
        trunk = carriers(model, model.body(config.torso).id)
        waist = [name for name in names if int(model.joint(name).bodyid[0]) in trunk]
        arms = [names[joint] for side in SIDES for joint in self.arm_joints(side)]
        neck = [config.neck.yaw, config.neck.pitch] if config.neck else []
        for number, pattern in enumerate(lend.waist):
            if others := [name for name in matching(names, pattern) if name not in waist]:
                message = f"{others[0]!r} is no joint of the waist: it does not carry the torso, {config.torso!r}"
                hint = f"those that do: {', '.join(waist)}" if waist else "none does: leave 'waist' out"
                yield Problem(message, policy.place("lend", "waist", number), hint, code="policy")
        for number, pattern in enumerate(lend.joints or ()):
            if not matching([*arms, *neck], pattern):
                message = f"no joint of the arms and the neck of robot.yaml matches {pattern!r}"
                hint = f"waist: [{pattern!r}]" if matching(waist, pattern) else nearest(pattern, [*arms, *neck])
                yield Problem(message, policy.place("lend", "joints", number), hint, code="policy")

    @property
    def leg_joints(self) -> list[int]:
        """The joints between the base and the feet, as indices of the arrays over joints."""
        model = self.model
        above = {body for leg in self.config.legs.values() for body in carriers(model, model.body(leg.sole.body).id)}
        return [j - 1 for j in range(1, model.njnt) if int(model.jnt_bodyid[j]) in above]

    def spec(self) -> mujoco.MjSpec:
        """Return a new editable model of the robot with its drives, sites and foot sensors."""
        config = self.config
        spec = read_model(config.model_file)
        _check_names(spec, config)
        _add_drives(spec, config)
        for body, others in config.collision.overlap.items():
            for other in others:
                spec.add_exclude(bodyname1=body, bodyname2=other)
        for side in SIDES:
            _add_frame(spec, sole_site(side), config, config.legs[side].sole, "legs", side, "sole")
            if side in config.hands:
                _add_site(spec, palm_site(side), config.hands[side], np.array([1.0, 0.0, 0.0, 0.0]))
            spec.add_sensor(
                name=foot_sensor(side),
                type=mujoco.mjtSensor.mjSENS_CONTACT,
                objtype=mujoco.mjtObj.mjOBJ_BODY,
                objname=config.legs[side].sole.body,
                intprm=[_FORCE, _NET, 1],
            )
        _add_gaze(spec, config)
        return spec


def learned_walker(config: RobotConfig) -> Policy | None:
    """Return the learned walker of a robot that is walked by one.

    Raises:
        UserError: there is none, or it has mistakes.
    """
    if config.body.walk != "policy":
        return None
    place = config.place("body", "policy")
    if config.body.policy is None:
        message, hint = "there is no learned walker", "body: {walk: policy, policy: walk.policy.yaml}"
        raise UserError(message, place, hint, code="missing-key")
    path = config.path.parent / config.body.policy
    if not is_file(path):
        raise UserError(
            f"the policy {config.body.policy!r} is missing", place, f"looked for {relative(path)}", "no-file"
        )
    return load_policy(path)


def _standing_as_learned(config: RobotConfig, policy: Policy | None) -> RobotConfig:
    """Return what ``robot.yaml`` says with the posture in which a learned walker stands as the home posture."""
    if policy is None:
        return config
    learned = dict(zip(policy.joints, policy.default_pose.tolist(), strict=True))
    others = {pattern: angle for pattern, angle in config.home.items() if pattern not in learned}
    return dataclasses.replace(config, home={**learned, **others})


def _compile(spec: mujoco.MjSpec, config: RobotConfig) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        raise UserError(f"the model does not compile: {_one_line(error)}", _model(config), code="model") from error


def _model(config: RobotConfig) -> Place:
    return Place(relative(config.model_file))


def _one_line(error: ValueError) -> str:
    return " ".join(str(error).split())


def _check_names(spec: mujoco.MjSpec, config: RobotConfig) -> None:
    """Refuse a ``robot.yaml`` that does not fit its model."""
    bodies = [body.name for body in spec.bodies if body.name and body != spec.worldbody]
    free = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    hinges = [joint.name for joint in spec.joints if joint.name and joint.type != mujoco.mjtJoint.mjJNT_FREE]
    problems: list[Problem] = []
    for keys, name in _named_bodies(config):
        if name not in bodies:
            hint = nearest(name, bodies)
            problems.append(Problem(f"the model has no body {name!r}", config.place(*keys), hint, code="unknown-body"))
    for keys, name in _named_joints(config):
        if name not in hinges:
            hint, place = nearest(name, hinges), config.place(*keys)
            problems.append(Problem(f"the model has no joint {name!r}", place, hint, code="unknown-joint"))
    for keys, pattern in _joint_patterns(config):
        if not matching(hinges, pattern):
            hint, place = nearest(pattern, hinges), config.place(*keys)
            problems.append(Problem(f"no joint of the model matches {pattern!r}", place, hint, code="unknown-joint"))
    floats = len(free) == 1 and spec.joints[0].type == mujoco.mjtJoint.mjJNT_FREE
    if not floats or (config.base in bodies and config.base != free[0].parent.name):
        hint = "a floating base: <freejoint/> in that body, before every other joint"
        wanted = f"the model must have exactly one free joint, on the base {config.base!r}"
        problems.append(Problem(wanted, config.place("base"), hint, code="model"))
    problems += model_problems(spec, _model(config))
    undriven = [name for name in hinges if config.drive(name) is None]
    if undriven:
        message = f"no group in 'drives' matches {', '.join(repr(name) for name in undriven)}"
        hint = "every joint needs a drive"
        problems.append(Problem(message, config.place("drives"), hint, code="undriven-joint"))
    if problems:
        raise UserError(problems)


_Reference = tuple[tuple[str | int, ...], str]  # keys in robot.yaml, and the name written there


def _named_bodies(config: RobotConfig) -> Iterator[_Reference]:
    yield ("base",), config.base
    yield ("torso",), config.torso
    for side, leg in config.legs.items():
        yield ("legs", side, "sole", "body"), leg.sole.body
    for side, hand in config.hands.items():
        yield ("hands", side, "body"), hand.body
    yield ("gaze", "body"), config.gaze.body
    for i, capsule in enumerate(config.collision.capsules):
        yield ("collision", "capsules", i, "body"), capsule.body
    for body, others in config.collision.overlap.items():
        yield ("collision", "overlap", body), body
        yield from ((("collision", "overlap", body, i), other) for i, other in enumerate(others))


def _named_joints(config: RobotConfig) -> Iterator[_Reference]:
    for side, leg in config.legs.items():
        for what in ("hip_roll", "hip_pitch", "ankle_pitch", "ankle_roll"):
            if (joint := getattr(leg, what)) is not None:
                yield ("legs", side, what), joint
    if config.neck:
        yield ("neck", "yaw"), config.neck.yaw
        yield ("neck", "pitch"), config.neck.pitch


def _joint_patterns(config: RobotConfig) -> Iterator[_Reference]:
    for i, drive in enumerate(config.drives):
        for k, pattern in enumerate(drive.joints):
            yield ("drives", i, "joints", k), pattern
    for pattern in config.home:
        yield ("home", pattern), pattern
    for name, patterns in config.groups.items():
        for k, pattern in enumerate(patterns):
            yield ("groups", name, k), pattern


def _overruled(config: RobotConfig, joints: Sequence[str]) -> Iterator[Problem]:
    """Yield the patterns that count for no joint, as what is wrong."""
    for table in ("drives", "home", "groups"):
        written = [(keys, pattern) for keys, pattern in _joint_patterns(config) if keys[0] == table]
        yield from overruled(((pattern, keys[:2], config.place(*keys)) for keys, pattern in written), joints)


def _add_drives(spec: mujoco.MjSpec, config: RobotConfig) -> None:
    """Give every joint a torque drive: force = ctrl - stiffness q - damping qd, within its limit and no other.

    Damping that the model gives a joint, and that is as large as a drive's, stands for that of the actuator which is
    dropped: position actuators of MJCF have none unless it is said. As friction it would eat up the drive's torque.
    """
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for joint in spec.joints:
        drive = config.drive(joint.name)
        if joint.type == mujoco.mjtJoint.mjJNT_FREE or drive is None:
            continue
        if float(joint.damping[0]) > max(_DRIVES_OWN * drive.damping, LEAST_DAMPING):
            joint.damping = np.zeros(3)
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_FALSE
        spec.add_actuator(
            PLAIN,
            name=joint.name,
            target=joint.name,
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            gaintype=mujoco.mjtGain.mjGAIN_FIXED,
            biastype=mujoco.mjtBias.mjBIAS_AFFINE,
            gainprm=[1.0] + [0.0] * 9,
            biasprm=[0.0, -drive.stiffness, -drive.damping] + [0.0] * 7,
            forcelimited=True,
            forcerange=[-drive.torque, drive.torque],
            ctrllimited=False,
        )


def axes_of(config: RobotConfig, frame: FrameConfig, *keys: str) -> Array:
    """Return the rotation from the frame of a sole or of the eyes to that of its body, shape (3, 3).

    Args:
        config: what ``robot.yaml`` says.
        frame: of it.
        keys: of the frame, for the place of a mistake.

    Raises:
        UserError: a direction is zero, or what is ahead is up.
    """
    up, ahead = np.array(frame.up), np.array(frame.ahead)
    for name, given in (("up", up), ("ahead", ahead)):
        if float(np.linalg.norm(given)) < _LEAST:
            raise UserError(f"{name!r} is no direction", config.place(*keys, name), "as [0, 0, 1]", "out-of-range")
    up, ahead = up / np.linalg.norm(up), ahead / np.linalg.norm(ahead)
    if abs(float(up @ ahead)) > _ALIKE:
        hint = "two directions across each other"
        raise UserError("what is ahead is up", config.place(*keys, "ahead"), hint, "site-off")
    ahead = ahead - (ahead @ up) * up
    ahead = ahead / np.linalg.norm(ahead)
    return np.column_stack([ahead, np.cross(up, ahead), up])


def _add_frame(spec: mujoco.MjSpec, name: str, config: RobotConfig, frame: FrameConfig, *keys: str) -> None:
    """Add a site that is turned as a frame is."""
    turn = np.zeros(4)
    mujoco.mju_mat2Quat(turn, axes_of(config, frame, *keys).flatten())
    _add_site(spec, name, frame, turn)


def _add_gaze(spec: mujoco.MjSpec, config: RobotConfig) -> None:
    """Add the site of the eyes, whose x axis is turned down."""
    gaze, turn = config.gaze, np.zeros(4)
    axes, down = axes_of(config, gaze, "gaze"), gaze.down
    cos, sin = math.cos(down), math.sin(down)
    mujoco.mju_mat2Quat(turn, (axes @ [[cos, 0.0, sin], [0.0, 1.0, 0.0], [-sin, 0.0, cos]]).flatten())
    _add_site(spec, GAZE_SITE, gaze, turn)


def _add_site(spec: mujoco.MjSpec, name: str, site: SiteConfig, turn: Array) -> None:
    spec.body(site.body).add_site(PLAIN, name=name, pos=list(site.position), quat=turn, size=[0.005] * 3, group=4)
