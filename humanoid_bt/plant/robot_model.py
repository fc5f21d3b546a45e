"""A robot compiled from its MJCF model and ``robot.yaml``: drives, sites and sensors are added, nothing is edited."""

from __future__ import annotations

from collections.abc import Iterable

import mujoco
import numpy as np

from humanoid_bt.errors import Place, Problem, UserError, nearest, relative
from humanoid_bt.messages import SIDES, Array
from humanoid_bt.plant.robot_config import RobotConfig, SiteConfig

BASE_DOFS = 6
BASE_COORDINATES = 7


def sole_site(side: str) -> str:
    """Return the name of a sole's site."""
    return f"hbt_{side}_sole"


def palm_site(side: str) -> str:
    """Return the name of a palm's site."""
    return f"hbt_{side}_palm"


GAZE_SITE = "hbt_gaze"


def foot_sensor(side: str) -> str:
    """Return the name of the contact-force sensor of a foot."""
    return f"hbt_{side}_foot_force"


class RobotModel:
    """A robot and its numbers as arrays over its joints, in the model's joint order.

    Args:
        config: what ``robot.yaml`` says.

    Raises:
        UserError: the MJCF file is not valid, or ``robot.yaml`` names what it does not have.

    Attributes:
        model: the robot alone, without floor or scene (the control layer's own copy).
        joint_names: names of the nj joints; joint i is coordinate 7 + i and degree of freedom 6 + i.
        lower, upper: soft limits, shape (nj,) [rad].
        stiffness, damping: drive gains, shape (nj,) [Nm/rad], [Nm s/rad].
        torque_limit: shape (nj,) [Nm].
        speed_limit: shape (nj,) [rad/s].
        home_qpos: home posture above the origin, feet not yet on the ground, shape (7 + nj,).
        mass: [kg].
    """

    def __init__(self, config: RobotConfig) -> None:
        self.config = config
        self.model = _compile(self.spec(), config)
        model = self.model
        self.joint_names = tuple(model.joint(j).name for j in range(1, model.njnt))
        drives = [config.drive(name) for name in self.joint_names]
        self.stiffness = np.array([drive.stiffness for drive in drives if drive])
        self.damping = np.array([drive.damping for drive in drives if drive])
        self.torque_limit = np.array([drive.torque for drive in drives if drive])
        self.speed_limit = np.array([drive.speed for drive in drives if drive])
        limited = model.jnt_limited[1:].astype(bool)
        margin = config.soft_limit_margin
        self.lower: Array = np.where(limited, model.jnt_range[1:, 0] + margin, -np.inf)
        self.upper: Array = np.where(limited, model.jnt_range[1:, 1] - margin, np.inf)
        home = np.array([config.home_angle(name) for name in self.joint_names])
        self.home_qpos: Array = np.concatenate([model.qpos0[:BASE_COORDINATES], np.clip(home, self.lower, self.upper)])
        self.mass = float(model.body_subtreemass[model.body(config.base).id])

    def joint(self, name: str) -> int:
        """Return a joint's index in the arrays over joints."""
        return self.joint_names.index(name)

    def spec(self) -> mujoco.MjSpec:
        """Return a new editable model of the robot with its drives, sites and foot sensors."""
        config = self.config
        spec = _read(config)
        _check_names(spec, config)
        for key in list(spec.keys):
            spec.delete(key)  # their size no longer fits once a scene is added
        _add_drives(spec, config)
        for side in SIDES:
            _add_site(spec, sole_site(side), config.legs[side].sole)
            if side in config.hands:
                _add_site(spec, palm_site(side), config.hands[side])
            spec.add_sensor(
                name=foot_sensor(side),
                type=mujoco.mjtSensor.mjSENS_CONTACT,
                objtype=mujoco.mjtObj.mjOBJ_BODY,
                objname=config.legs[side].sole.body,
                intprm=[
                    1 << int(mujoco.mjtConDataField.mjCONDATA_FORCE),
                    3,
                    1,
                ],  # force, summed over contacts, one slot
            )
        _add_site(spec, GAZE_SITE, config.gaze)
        return spec


def _read(config: RobotConfig) -> mujoco.MjSpec:
    path = config.path.parent / config.model
    try:
        return mujoco.MjSpec.from_file(str(path))
    except ValueError as error:
        raise UserError(f"not a valid MJCF model: {_first_line(error)}", Place(relative(path))) from error


def _compile(spec: mujoco.MjSpec, config: RobotConfig) -> mujoco.MjModel:
    try:
        return spec.compile()
    except ValueError as error:
        path = config.path.parent / config.model
        raise UserError(f"the model does not compile: {_first_line(error)}", Place(relative(path))) from error


def _first_line(error: ValueError) -> str:
    return " ".join(str(error).split())


def _check_names(spec: mujoco.MjSpec, config: RobotConfig) -> None:
    place = Place(relative(config.path))
    bodies = [body.name for body in spec.bodies]
    free = [joint for joint in spec.joints if joint.type == mujoco.mjtJoint.mjJNT_FREE]
    hinges = [joint.name for joint in spec.joints if joint.type != mujoco.mjtJoint.mjJNT_FREE]
    problems: list[Problem] = []

    def need(what: str, names: Iterable[str], valid: list[str]) -> None:
        problems.extend(
            Problem(f"the model has no {what} {name!r}", place, nearest(name, valid))
            for name in names
            if name not in valid
        )

    legs = config.legs.values()
    sites = [leg.sole for leg in legs] + list(config.hands.values()) + [config.gaze]
    need("body", [config.base, config.torso, *(site.body for site in sites)], bodies)
    need("joint", [j for leg in legs for j in (leg.hip_roll, leg.hip_pitch, leg.ankle_pitch, leg.ankle_roll)], hinges)
    if config.neck:
        need("joint", [config.neck.yaw, config.neck.pitch], hinges)
    if len(free) != 1 or free[0].parent.name != config.base:
        problems.append(Problem(f"the model must have exactly one free joint, on the base {config.base!r}", place))
    if any(joint.type != mujoco.mjtJoint.mjJNT_HINGE for joint in spec.joints if joint not in free):
        problems.append(Problem("every joint but the base's must be a hinge", place))
    if list(spec.equalities):
        problems.append(Problem("the model has equality constraints; the robot must stand on its own", place))
    problems += [
        Problem(f"no group in 'drives' matches the joint {name!r}", place, "every joint needs a drive")
        for name in hinges
        if config.drive(name) is None
    ]
    if problems:
        raise UserError(problems)


def _add_drives(spec: mujoco.MjSpec, config: RobotConfig) -> None:
    """Give every joint a torque drive: force = ctrl - stiffness q - damping qd, within its limit."""
    for actuator in list(spec.actuators):
        spec.delete(actuator)
    for joint in spec.joints:
        drive = config.drive(joint.name)
        if joint.type == mujoco.mjtJoint.mjJNT_FREE or drive is None:
            continue
        spec.add_actuator(
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


def _add_site(spec: mujoco.MjSpec, name: str, site: SiteConfig) -> None:
    spec.body(site.body).add_site(name=name, pos=list(site.position), size=[0.005] * 3, group=4)
