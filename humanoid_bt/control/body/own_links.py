"""The robot's links as capsules in a model of their own, so that MuJoCo finds those that are near each other."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import mujoco
import numpy as np

from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.robot.capsules import capsules
from humanoid_bt.robot.model import RobotModel, carriers
from humanoid_bt.robot.published import PLAIN

_CAPSULE, _END = 1, 2  # kinds of shapes, as bits of MuJoCo's: capsules meet capsules and ends, ends meet no ends
_OURS = (["hbt", "capsule"], ["hbt", "end"])
_AT_HOME = 0.9  # of their distance in the home posture; nearer than this two are near: at home none are
_NOD = 0.005  # m at most that a head is kept from the trunk: it is to see what is near and low
_NEVER = -1.0  # m that two are kept apart that need not be: they may be in each other


class OwnLinks:
    """Finds the links that are near each other.

    The ends of a capsule are balls of their own. Where two lie side by side, their nearest points jump from one end to
    the other; those of an end move smoothly, and both ends of them are seen.

    Left out are shapes of one link and of two that a joint joins, those that the model excludes, and those that are in
    each other in the home posture, as neighbours may be. Two that are near there may come half as near, or they could
    not move at all. Legs among themselves are left to the gait: a step that catches a push must not be held up. A trunk
    and a hip, or a trunk and a head, that are within the margin there are neighbours whichever of their shapes meet: a
    trunk that is held up as it turns on a hip would lift the whole robot, or turn its feet on the ground, and a head
    that is held up as it nods would not see what is near and low. Other heads come as near to the trunk as their shapes
    let them.

    Args:
        robot: the robot.
        near: beyond the margin of ``robot.yaml``, what counts as near [m].

    Attributes:
        model: the robot's, with capsules in place of its shapes that touch.
        margins: how far apart two shapes of it are kept, shape (ngeom, ngeom) [m].
        begins: how far apart they begin to count as near, shape (ngeom, ngeom) [m].
    """

    def __init__(self, robot: RobotModel, near: float) -> None:
        margin, shapes = robot.config.collision.margin, capsules(robot)
        spec = robot.spec()
        for pair in list(spec.pairs):
            spec.delete(pair)
        for geom in spec.geoms:
            geom.contype = geom.conaffinity = 0
        legs, arms = _leg_bodies(robot), _arm_bodies(robot)
        for number, shape in enumerate(shapes):
            body = spec.body(robot.model.body(shape.body).name)
            _add(body, f"hbt_capsule_{number}", shape.ends, shape.radius)
            for end, place in enumerate(shape.ends if body.name in arms else ()):
                _add(body, f"hbt_end_{number}_{end}", place[None], shape.radius, _END)
        for geom in spec.geoms:
            geom.margin = (margin + near) / 2  # of two they add up
        for one, other in itertools.combinations(legs, 2):
            spec.add_exclude(bodyname1=one, bodyname2=other)
        spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        disable = mujoco.mjtDisableBit
        spec.option.disableflags |= disable.mjDSBL_LIMIT | disable.mjDSBL_FRICTIONLOSS  # only contacts are asked for
        spec.compiler.discardvisual = True
        self.model: mujoco.MjModel = spec.compile()
        model = self.model
        names = [model.geom(geom).name.split("_") for geom in range(model.ngeom)]
        number_of = np.array([int(name[2]) if name[:2] in _OURS else -1 for name in names])
        kept: Array = np.full((len(shapes), len(shapes)), margin)
        bodies = [shape.body for shape in shapes]
        of_trunk, of_head = (np.isin(bodies, [*part]) for part in (trunk_bodies(robot), head_bodies(robot)))
        nods = np.logical_and.outer(of_trunk, of_head)
        kept[nods | nods.T] = min(margin, _NOD)
        begins = kept + near
        home = mujoco.MjData(model)
        home.qpos[:] = robot.home_qpos
        mujoco.mj_kinematics(model, home)
        mujoco.mj_comPos(model, home)
        mujoco.mj_collision(model, home)
        for (one, other), distance in zip(
            number_of[home.contact.geom].tolist(), home.contact.dist.tolist(), strict=True
        ):
            pairs = ([one, other], [other, one])
            kept[pairs] = min(distance / 2, kept[one, other]) if distance > 0 else _NEVER
            begins[pairs] = min(_AT_HOME * distance, begins[one, other]) if distance > 0 else _NEVER
        for pair in _neighbours(robot, legs, home):
            ours = (np.isin(bodies, body) for body in pair)
            met = np.logical_and.outer(*ours)
            kept[met | met.T] = begins[met | met.T] = _NEVER
        self.margins, self.begins = (table[number_of[:, None], number_of] for table in (kept, begins))


def _add(body: mujoco.MjsBody, name: str, points: Array, radius: float, kind: int = _CAPSULE) -> None:
    """Add a shape that weighs nothing: a capsule between two points, or a ball at one."""
    geom = body.add_geom(PLAIN, name=name, size=[radius, 0, 0], mass=0, contype=kind, condim=1)
    geom.conaffinity = _CAPSULE | _END if kind == _CAPSULE else 0
    if (points == points[0]).all():
        geom.type, geom.pos = mujoco.mjtGeom.mjGEOM_SPHERE, points[0]
    else:
        geom.type, geom.fromto = mujoco.mjtGeom.mjGEOM_CAPSULE, points.ravel()


def _neighbours(robot: RobotModel, legs: Sequence[str], home: mujoco.MjData) -> set[tuple[int, int]]:
    """Return the bodies of the trunk, and of the legs and the neck, that are within the margin in the home posture.

    Args:
        robot: the robot.
        legs: names of the base and of the legs' bodies.
        home: the shapes, with the contacts of that posture.
    """
    model, trunk = home.model, trunk_bodies(robot)
    near = home.contact.dist < robot.config.collision.margin
    touching = {tuple(pair) for pair in model.geom_bodyid[home.contact.geom[near]].tolist()}
    limbs = {model.body(name).id for name in legs} - trunk | head_bodies(robot)
    return {(one, other) for a, b in touching for one, other in ((a, b), (b, a)) if one in trunk and other in limbs}


def trunk_bodies(robot: RobotModel) -> set[int]:
    """Return the bodies from the torso to the base."""
    return set(carriers(robot.model, robot.model.body(robot.config.torso).id)) - {0}


def head_bodies(robot: RobotModel) -> set[int]:
    """Return the bodies between the trunk and the eyes, if there is a neck."""
    model, config = robot.model, robot.config
    above = set(carriers(model, model.body(config.gaze.body).id)) - trunk_bodies(robot) - {0}
    return above if config.neck else set()


def _leg_bodies(robot: RobotModel) -> list[str]:
    """Return the base and the bodies of the legs."""
    model, config = robot.model, robot.config
    hips = {carriers(model, model.body(config.legs[side].sole.body).id)[-3] for side in SIDES}
    legs = [body for body in range(model.nbody) if hips & set(carriers(model, body))]
    return [config.base, *(model.body(body).name for body in legs)]


def _arm_bodies(robot: RobotModel) -> set[str]:
    """Return the bodies from the torso to the palms."""
    model, config = robot.model, robot.config
    arms = {body for hand in config.hands.values() for body in carriers(model, model.body(hand.body).id)}
    return {model.body(body).name for body in arms - set(carriers(model, model.body(config.torso).id))}
