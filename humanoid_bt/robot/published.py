"""A published model as it is read: the robot alone, on a free base, or what of it no robot here can have."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import mujoco

from humanoid_bt.core.errors import Place, Problem, UserError, relative
from humanoid_bt.core.texts import few, listed
from humanoid_bt.robot import mujoco_warnings

OWN = "hbt_"
"""What the names of all begin with that is added to a model."""

PLAIN = mujoco.MjSpec().default
"""MuJoCo's own defaults: what is added to a model is as it is said, whatever classes of defaults the model has."""


def read_model(path: Path) -> mujoco.MjSpec:
    """Return a published model, MJCF or URDF, as it can be edited: the robot alone, on a free base.

    The robot is the body of the world with the most hinges. What else the world has is left out: floors, things,
    lights, cameras, and what names them; keyframes and sensors, too. Geoms that a pair lets touch a floor can touch
    any, then. A model without a free joint, as those that a simulator adds one to, gets it at its root. The base is
    upright above the origin, however the file has it in the world. There is gravity, and nothing of physics is switched
    off.

    Meshes of a ROS package, as `package://my_robot/meshes/foot.stl`, are looked for in the folder of that name that the
    model is in, or that lies beside one of those.

    Raises:
        UserError: it is no valid MJCF or URDF, or its meshes are not there, or of another kind than MuJoCo reads.
    """
    if not _is_utf8(path):
        message, hint = "MuJoCo reads no model whose path is not in UTF-8", "rename the file or its folder"
        raise UserError(message, Place(relative(path)), hint, code="model")
    mujoco_warnings.hear()
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        list(spec.worldbody.geoms)  # tells of joints of a URDF that have one name, which reading it does not
    except ValueError as error:
        kind = "URDF" if path.suffix.lower() == ".urdf" else "MJCF"
        raise UserError(
            f"not a valid {kind} model: {' '.join(str(error).split())}", Place(relative(path)), code="model"
        ) from error
    _find_meshes(spec, path)
    spec.compiler.fusestatic = False  # of a URDF, whose root would become part of the world
    beside = _beside(spec)
    _touch_any_floor(spec, beside)
    _leave_out(spec, beside)
    _free_base(spec)
    _put_upright(spec)
    _switch_on(spec)
    return spec


def _is_utf8(path: Path) -> bool:
    try:
        str(path).encode()
    except UnicodeEncodeError:
        return False
    return True


def _find_meshes(spec: mujoco.MjSpec, path: Path) -> None:
    """Name the files of meshes that a URDF names by a ROS package, and refuse what MuJoCo cannot read."""
    kinds = [kind for mesh in spec.meshes if (kind := Path(mesh.file).suffix.lower()) in _OTHER_MESHES]
    if kinds:
        which = " and ".join(sorted(set(kinds)))
        count = f"{len(kinds)} meshes are {which} files" if len(kinds) > 1 else f"1 mesh is a {which} file"
        message = f"{count}, which MuJoCo does not read"
        hint = (
            "make .stl or .obj files of them, and name those in a copy of the model; in Python, trimesh does it,"
            " in metres: trimesh.load('foot.dae', force='mesh').export('foot.stl')"
        )
        raise UserError(message, Place(relative(path)), hint, code="model")
    for mesh in spec.meshes:
        if not mesh.file.startswith(_PACKAGE):
            continue
        package, _, rest = mesh.file.removeprefix(_PACKAGE).partition("/")
        roots = [root for folder in path.resolve().parents for root in (folder, folder / package)]
        there = [root / rest for root in roots if root.name == package and (root / rest).is_file()]
        if not there:
            message = f"there is no {mesh.file!r}"
            hint = f"looked for {rest} in folders named {package!r} that the model is in, or that are beside those"
            raise UserError(message, Place(relative(path)), hint, code="model")
        mesh.file = str(there[0])


def _beside(spec: mujoco.MjSpec) -> list[mujoco.MjsBody]:
    """Return the bodies that stand in the world beside the robot."""
    bodies = list(spec.worldbody.bodies)
    hinges = [
        sum(joint.type == mujoco.mjtJoint.mjJNT_HINGE for joint in body.find_all(mujoco.mjtObj.mjOBJ_JOINT))
        for body in bodies
    ]
    return [body for body, count in zip(bodies, hinges, strict=True) if count < max(hinges)]


def _touch_any_floor(spec: mujoco.MjSpec, beside: list[mujoco.MjsBody]) -> None:
    """Make of pairs with what is not of the robot, as a floor, geoms that can touch."""
    others = {geom.name for body in beside for geom in body.find_all(mujoco.mjtObj.mjOBJ_GEOM)}
    others |= {geom.name for geom in spec.worldbody.geoms}
    geoms = {geom.name: geom for geom in spec.geoms if geom.name and geom.name not in others}
    for pair in list(spec.pairs):
        there = [geoms[name] for name in (pair.geomname1, pair.geomname2) if name in geoms]
        if len(there) < 2:
            spec.delete(pair)
            for geom in there:
                if not (geom.contype or geom.conaffinity):
                    geom.contype = geom.conaffinity = 1


def _leave_out(spec: mujoco.MjSpec, beside: list[mujoco.MjsBody]) -> None:
    """Take out of the world what is not of the robot; what names such a body goes with it.

    Keyframes no longer fit once a scene is there; sensors may read what is left out, or actuators that are replaced.
    """
    world = spec.worldbody
    for element in [*spec.keys, *spec.sensors, *world.geoms, *world.lights, *world.cameras]:
        spec.delete(element)
    names = {part.name for body in beside for part in (body, *body.find_all(mujoco.mjtObj.mjOBJ_BODY))}
    for look in [*spec.lights, *spec.cameras]:
        if look.targetbody and look.targetbody in names:
            spec.delete(look)
    for body in beside:
        spec.delete(body)


def _free_base(spec: mujoco.MjSpec) -> None:
    """Add a free joint to the only body that stands in the world and carries joints, if there is none."""
    if any(joint.type == mujoco.mjtJoint.mjJNT_FREE for joint in spec.joints):
        return
    roots = [body for body in spec.worldbody.bodies if body.find_all(mujoco.mjtObj.mjOBJ_JOINT)]
    if len(roots) == 1 and not roots[0].joints:
        roots[0].add_freejoint()


def _put_upright(spec: mujoco.MjSpec) -> None:
    """Turn what floats so that its frame is the world's: a model may lie, for a simulation that lets it get up."""
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            base = joint.parent
            base.pos, base.quat, base.alt.type = [0.0, 0.0, base.pos[2]], [1.0, 0.0, 0.0, 0.0], _BY_QUAT
            if base.frame:
                base.set_frame(spec.worldbody.add_frame())


def _switch_on(spec: mujoco.MjSpec) -> None:
    """Take back what a model says of the world, as for a viewer in which nothing falls, and solvers that stop early."""
    option, usual = spec.option, mujoco.MjSpec().option
    for key in ("gravity", "wind", "density", "viscosity", "disableactuator"):
        setattr(option, key, getattr(usual, key))
    option.disableflags &= ~_PHYSICS
    option.enableflags = 0
    option.iterations = max(option.iterations, usual.iterations)
    option.ls_iterations = max(option.ls_iterations, usual.ls_iterations)


def model_problems(spec: mujoco.MjSpec, where: Place) -> Iterator[Problem]:
    """Yield what a model has that no robot here can have.

    Args:
        spec: the model.
        where: its file.
    """
    for kind, parts in (("body", spec.bodies), ("joint", spec.joints)):
        for part in parts:
            if not part.name and getattr(part, "type", None) != mujoco.mjtJoint.mjJNT_FREE:
                message = f"the model has a {kind} without a name, on {part.parent.name!r}"
                hint = "give it one: robot.yaml, recordings and messages say by their names which they mean"
                yield Problem(message, _line(part.info, where), hint, code="model")
    sliding = [joint for joint in spec.joints if joint.type not in _ROBOT_JOINTS]
    if sliding:
        message = f"only hinges can be driven; these joints are none: {', '.join(joint.name for joint in sliding)}"
        of_base = any(joint.parent in spec.worldbody.bodies for joint in sliding)
        yield Problem(message, _line(sliding[0].info, where), _FREE_BASE if of_base else "", code="model")
    if equalities := list(spec.equalities):
        listing = ", ".join(
            f"{(one.name or one.name1)!r} ({one.type.name.removeprefix('mjEQ_').lower()})" for one in equalities
        )
        number = f"{len(equalities)} equality constraints" if len(equalities) > 1 else "the equality constraint"
        message = f"the model has {number} {listing}, and no robot here can have any"
        yield Problem(message, _line(equalities[0].info, where), _FREE_JOINTS, code="model")
    if ours := [site.name for site in spec.sites if site.name.startswith(OWN)]:
        hint = (
            f"names that begin with {OWN} are those of what is added: take these sites out of the model, or rename them"
        )
        yield Problem(f"the model has sites that are added to it: {listed(ours)}", where, hint, code="model")
    for tendon in spec.tendons:
        if any(getattr(wrap.target, "parent", None) == spec.worldbody for wrap in tendon.path):
            message = f"the tendon {tendon.name!r} ties the robot to the world, and it must stand by itself"
            yield Problem(message, _line(tendon.info, where), "take it out of the model", code="model")
    if floating := [body for body in spec.bodies if body.gravcomp]:
        which = listed(few([repr(body.name) for body in floating], _NAMED))
        message = f"gravcomp carries {which}, and the robot must carry its own weight"
        yield Problem(message, _line(floating[0].info, where), "take it out of the model", code="model")


def _line(info: str, where: Place) -> Place:
    """Return the place of an element of a model's file, of which MuJoCo says "line 12"."""
    line = re.search(r"line (\d+)", info)
    return Place(where.file, int(line[1]), 1) if line else where


_NAMED = 4  # bodies, at most
_PACKAGE = "package://"
_OTHER_MESHES = (".dae", ".wrl", ".fbx", ".ply", ".step", ".3ds")
_FREE_BASE = "a base that slides and turns by joints of its own: put one <freejoint/> in the place of all of them"
_FREE_JOINTS = (
    "control takes every joint for one that moves and is driven by itself. Of a closed chain, as the rods of an ankle"
    " are, keep the joints that tilt the foot and take the rods out; of coupled fingers drive each (in a URDF,"
    " take their <mimic> out)"
)
_OFF = mujoco.mjtDisableBit
_PHYSICS = (_OFF.mjDSBL_CONSTRAINT | _OFF.mjDSBL_FRICTIONLOSS | _OFF.mjDSBL_LIMIT | _OFF.mjDSBL_CONTACT) | (
    _OFF.mjDSBL_SPRING | _OFF.mjDSBL_DAMPER | _OFF.mjDSBL_GRAVITY | _OFF.mjDSBL_ACTUATION | _OFF.mjDSBL_SENSOR
)
_BY_QUAT = mujoco.mjtOrientation.mjORIENTATION_QUAT
_ROBOT_JOINTS = (mujoco.mjtJoint.mjJNT_FREE, mujoco.mjtJoint.mjJNT_HINGE)
