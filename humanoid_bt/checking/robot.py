"""Whether a robot.yaml fits its model: what its numbers say of feet, joints, sites and limits."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from pathlib import Path

import mujoco
import numpy as np

from humanoid_bt.core.errors import Problem, relative
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.core.reading import with_article
from humanoid_bt.robot.capsules import capsules
from humanoid_bt.robot.config import SiteConfig, load_robot_config
from humanoid_bt.robot.footprint import footprint
from humanoid_bt.robot.model import GAZE_SITE, RobotModel, axes_of, carriers, palm_site, sole_site
from humanoid_bt.robot.survey.drives import without_limits
from humanoid_bt.robot.survey.limbs import NoHumanoidError, Surveyor
from humanoid_bt.robot.survey.size import odd_size

_SOLE_OFF = 0.01  # m of height, ...
_SOLE_ASIDE = 0.02  # ...or along the floor: nearer counts as right
_SOLE_LARGER, _SOLE_OVER = 1.1, 0.002  # than the foot, as a factor and in m: a centre of pressure must get there
_ALONG = 0.7  # cosine between a joint's axis and that of its role; hips are often a little oblique
_MIRRORED = 0.01  # m between a point and its mirror image on the other side
_NEAR_BODY = 0.15  # m of a palm or of eyes from what carries them
_MASS = (1.0, 200.0)  # kg
_AXES = {"hip_roll": 0, "hip_pitch": 1, "ankle_pitch": 1, "ankle_roll": 0}
_SWAY = 0.08  # m that a walking robot reaches farther than a standing one
_FALL_TILT, _FALL_HEIGHT = (0.3, 1.3), (0.3, 0.9)  # rad; share of the height


def robot_problems(path: Path) -> list[Problem]:
    """Return what is wrong with a robot, in its file or as it stands, reaches and walks.

    Raises:
        UserError: it cannot be loaded.
    """
    robot = RobotModel(load_robot_config(path))
    found = list(_odd_size(robot)) or list(_learned_outside(robot)) or _blamed(robot, list(_implausible(robot)))
    found += robot.policy.warnings if robot.policy else ()
    if any(problem.severity == "error" for problem in found):
        return found  # it would only fall over them
    from humanoid_bt.checking.robot_motion import tried  # noqa: PLC0415 (control, which takes a while)

    return [*found, *tried(robot)]


def _odd_size(robot: RobotModel) -> Iterator[Problem]:
    """Yield a height that no humanoid has: every other number would look wrong, too."""
    if message := odd_size(Surveyor(robot.model)):
        hint = "scale positions, sizes and meshes of the model, as by 0.001 from millimetres"
        yield Problem(message, robot.config.place("model"), hint, code="odd-size")


def _learned_outside(robot: RobotModel) -> Iterator[Problem]:
    """Yield angles of a learned walker's default pose that are outside: in such a pose all else would look wrong."""
    policy = robot.policy
    for name, angle in zip(policy.joints, policy.default_pose.tolist(), strict=True) if policy else ():
        index = robot.joint(name)
        low, high = float(robot.lower[index]), float(robot.upper[index])
        if policy and not low <= angle <= high:
            message = f"the default angle of {name!r}, {angle:g} rad, is outside its soft limits"
            hint = f"valid: {low:.2f} to {high:.2f} rad; is it in rad, and in the order of joints?"
            yield Problem(message, policy.angle_place(name), hint, code="home-outside")


def _blamed(robot: RobotModel, found: list[Problem]) -> list[Problem]:
    """Return findings, at a learned walker's default pose if they are none of the home posture of ``robot.yaml``."""
    config, policy = robot.config, robot.policy
    if policy is None or not found:
        return found
    body = dataclasses.replace(config.body, walk="dcm")
    own = RobotModel(dataclasses.replace(load_robot_config(config.path), body=body))
    known = {(problem.code, problem.place) for problem in _implausible(own)}
    hint = f"so it is in the default pose of {relative(policy.config.path)}: is it in rad, and in the order of joints?"
    return [
        problem
        if (problem.code, problem.place) in known
        else dataclasses.replace(problem, place=policy.pose_place, hint=hint)
        for problem in found
    ]


def _implausible(robot: RobotModel) -> Iterator[Problem]:
    yield from _forgotten_hand(robot)
    yield from _without_limits(robot)
    yield from _odd_numbers(robot)
    outside = list(_home_outside(robot))
    yield from outside or _implausible_at_home(robot)  # in such a posture all else would look wrong


def _implausible_at_home(robot: RobotModel) -> Iterator[Problem]:
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.home_qpos
    mujoco.mj_kinematics(robot.model, data)
    roles = list(_wrong_joints(robot))
    yield from roles
    yield from _wrong_neck(robot)
    yield from _soles_off(robot)
    yield from _wrong_bodies(robot, data)
    if not roles:
        yield from _asymmetries(robot, data)
    yield from _wider_than_said(robot, data)


def _wrong_joints(robot: RobotModel) -> Iterator[Problem]:
    """Yield joints that do not do what their role in a leg is."""
    config, model = robot.config, robot.model
    chains = {side: _joints_above(model, config.legs[side].sole.body) for side in SIDES}
    shared = set[str].intersection(*map(set, chains.values()))
    for side, chain in chains.items():
        leg = config.legs[side]
        pitches = [j for j in chain if j not in shared and abs(robot.axes[robot.joint(j), 1]) >= _ALONG]
        hips, ankles = chain, chain  # hips are above the knee, and ankles below it
        if len(pitches) > 1:
            hips, ankles = chain[: chain.index(pitches[1])], chain[chain.index(pitches[-2]) + 1 :]
        for role, axis in _AXES.items():
            joint, place = getattr(leg, role), config.place("legs", side, role)
            if joint is None:
                yield from _unnamed_roll(robot, side, chain)
                continue
            turns = robot.axes[robot.joint(joint)]
            part, those = ("hip", hips) if role.startswith("hip") else ("ankle", ankles)
            if joint not in chain:
                hint = f"the joints of this leg: {', '.join(chain)}"
                yield Problem(f"{joint!r} does not move the {side} sole", place, hint, code="joint-role")
            elif abs(turns[axis]) < _ALONG:
                fits = [name for name in chain if abs(robot.axes[robot.joint(name), axis]) >= _ALONG]
                hint = f"of this leg these turn about {'xyz'[axis]}: {', '.join(fits)}" if fits else "turn its axis"
                message = f"{joint!r} turns about {_axis(turns)}, {with_article(role)} joint about {'xyz'[axis]}"
                yield Problem(message, place, hint, code="joint-role")
            elif joint not in those:
                hint = f"from the {config.base} down: {', '.join(chain)}"
                yield Problem(f"{joint!r} is no {part} joint", place, hint, code="joint-role")


def _unnamed_roll(robot: RobotModel, side: Side, chain: list[str]) -> Iterator[Problem]:
    """Yield that a foot is tilted sideways by a joint that robot.yaml does not name.

    Args:
        robot: the robot.
        side: of a leg without ankle roll.
        chain: its joints, from the base down.
    """
    leg = robot.config.legs[side]
    below = chain[chain.index(leg.hip_pitch) + 1 :] if leg.hip_pitch in chain else []
    for joint in below:
        if joint != leg.hip_roll and abs(robot.axes[robot.joint(joint), 0]) >= _ALONG:
            place = robot.config.place("legs", side)
            message = f"{joint!r} tilts the {side} foot sideways, and no ankle_roll is named"
            yield Problem(message, place, f"ankle_roll: {joint}", code="joint-role")


def _wrong_neck(robot: RobotModel) -> Iterator[Problem]:
    """Yield joints of the neck that do not turn the head as they shall."""
    config = robot.config
    if config.neck is None:
        return
    above = _joints_above(robot.model, config.gaze.body)
    for role, axis in (("yaw", 2), ("pitch", 1)):
        joint, place = getattr(config.neck, role), config.place("neck", role)
        turns = robot.axes[robot.joint(joint)]
        if joint not in above:
            hint = f"these do: {', '.join(above)}"
            yield Problem(f"{joint!r} does not move the eyes", place, hint, code="joint-role")
        elif abs(turns[axis]) < _ALONG:
            message = f"{joint!r} turns about {_axis(turns)}, the neck's {role} about {'xyz'[axis]}"
            yield Problem(message, place, "x is ahead, y left, z up", code="joint-role")


def _soles_off(robot: RobotModel) -> Iterator[Problem]:
    """Yield soles that are not where the feet touch the floor, or larger than what of a foot touches it."""
    config = robot.config
    halves: list[Array] = []
    for side in SIDES:
        sole = config.legs[side].sole
        place = config.place("legs", side, "sole", "position")
        foot = footprint(robot, side)
        if foot is None:
            message = f"nothing of the body {sole.body!r} can touch the floor"
            hint = "the sole's body must have collision geoms"
            yield Problem(message, config.place("legs", side, "sole", "body"), hint, code="sole-off")
            continue
        off = (np.array(sole.position) - foot.centre) @ axes_of(config, sole, "legs", side, "sole")
        height, aside = abs(off[2]), float(np.linalg.norm(off[:2]))
        hint = f"the foot touches the floor around position: {_numbers(foot.centre)}"
        if height > _SOLE_OFF:
            message = (
                f"the {side} sole is {height * 100:.1f} cm {'above' if off[2] > 0 else 'below'} the foot's lowest point"
            )
            yield Problem(message, place, hint, code="sole-off")
        elif aside > _SOLE_ASIDE:
            message = f"the {side} sole is {aside * 100:.1f} cm beside the middle of the foot"
            yield Problem(message, place, hint, code="sole-off")
        halves.append(foot.half)
    for key, *of_feet in zip(("half_length", "half_width"), *halves, strict=True):
        half, most = getattr(config.sole, key), min(of_feet, default=math.inf)
        if half > _SOLE_LARGER * most + _SOLE_OVER:
            message = f"the sole is larger than the foot: {key} {half:g} m"
            yield Problem(message, config.place("sole", key), f"of the foot: {most:.3f} m", code="sole-size")


def _home_outside(robot: RobotModel) -> Iterator[Problem]:
    """Yield angles of the home posture that the joints' soft limits do not allow."""
    config = robot.config
    for pattern, angle in config.home.items():
        for index, name in enumerate(robot.joint_names):
            low, high = float(robot.lower[index]), float(robot.upper[index])
            if config.home_key(name) == pattern and not low <= angle <= high:
                message = f"the home angle of {name!r}, {angle:g} rad, is outside its soft limits"
                hint = f"valid: {low:.2f} to {high:.2f} rad"
                yield Problem(message, config.place("home", pattern), hint, code="home-outside")
                break


def _wrong_bodies(robot: RobotModel, data: mujoco.MjData) -> Iterator[Problem]:
    """Yield a torso that carries no arms, and sites that are far from the bodies that carry them or look back."""
    config, model = robot.config, robot.model
    torso = model.body(config.torso).id
    sites: dict[str, tuple[tuple[str, ...], str, SiteConfig]] = {
        side: (("hands", side), palm_site(side), hand) for side, hand in config.hands.items()
    }
    sites["gaze"] = (("gaze",), GAZE_SITE, config.gaze)
    for what, (keys, name, site) in sites.items():
        title = "the eyes are" if what == "gaze" else f"the {what} palm is"
        if torso not in carriers(model, model.body(site.body).id):
            message = f"{title} on {site.body!r}, which the torso {config.torso!r} does not carry"
            yield Problem(message, config.place("torso"), f"or {'.'.join(keys)}.body", code="wrong-torso")
        away = _away(model, data, site.body, data.site(name).xpos)
        if away > _NEAR_BODY:
            message = f"{title} {away * 100:.0f} cm away from the body {site.body!r}"
            yield Problem(message, config.place(*keys, "position"), "a position in the body's frame", code="site-off")
    ahead = data.body(config.gaze.body).xmat.reshape(3, 3) @ axes_of(config, config.gaze, "gaze")[:, 0]
    height = data.site(GAZE_SITE).xpos[2] - data.body(config.base).xpos[2]
    if ahead @ data.body(config.base).xmat[[0, 3, 6]] < _ALONG:
        message = f"the eyes do not look ahead: what is ahead of {config.gaze.body!r} points along {_axis(ahead)}"
        hint = "ahead and up say which directions of the body's frame these are; x and z if they are left out"
        yield Problem(message, config.place("gaze", "body"), hint, code="site-off")
    elif height < 0:
        message = f"the eyes are {-height * 100:.0f} cm below the base"
        yield Problem(message, config.place("gaze"), "the eyes are in the head", code="site-off")


def _forgotten_hand(robot: RobotModel) -> Iterator[Problem]:
    """Yield an arm of the model that has no hand, although the other one has."""
    hands = robot.config.hands
    if not hands or set(hands) == set(SIDES):
        return
    try:
        arms = Surveyor(robot.model).limbs().arms
    except NoHumanoidError:
        return
    for side in set(arms) - set(hands):
        body = robot.model.body(arms[side].body).name
        message = f"the model has a {side} arm, and 'hands' has no key {side!r}"
        hint = f"{side}: {{body: {body}, position: [...]}}, or neither hand"
        yield Problem(message, robot.config.place("hands"), hint, code="missing-key")


def _asymmetries(robot: RobotModel, data: mujoco.MjData) -> Iterator[Problem]:
    """Yield sides that are swapped, or that do not mirror each other in the home posture."""
    config = robot.config
    base = data.body(config.base)
    for keys, site in ((("legs",), sole_site), (("hands",), palm_site)):
        if keys == ("hands",) and set(config.hands) != set(SIDES):
            continue
        left, right = (base.xmat.reshape(3, 3).T @ (data.site(site(side)).xpos - base.xpos) for side in SIDES)
        what = "soles" if keys == ("legs",) else "palms"
        off = float(np.linalg.norm(left - right * [1, -1, 1]))
        if _on_one_limb(robot, site):
            message = f"the {what} of both sides are on the same limb"
            yield Problem(message, config.place(*keys, "left", "sole"), "a body of each side", code="swapped-sides")
        elif left[1] < right[1]:
            message = f"the left of the {what} is on the right: left and right are swapped"
            yield Problem(message, config.place(*keys, "left", "sole"), "y points to the left", code="swapped-sides")
        elif off > _MIRRORED:
            message = f"the {what} do not mirror each other in the home posture: {off * 100:.0f} cm off"
            place = config.place("home") if what == "palms" else config.place("legs")
            hint = "look at the signs of roll and yaw angles in home, and at the sites' positions"
            yield Problem(message, place, hint, code="asymmetric", severity="warning")


def _on_one_limb(robot: RobotModel, site: Callable[[str], str]) -> bool:
    """Return whether one of both sites is on a body that carries that of the other, or on the same."""
    left, right = (int(robot.model.site(site(side)).bodyid[0]) for side in SIDES)
    return left in carriers(robot.model, right) or right in carriers(robot.model, left)


def _without_limits(robot: RobotModel) -> Iterator[Problem]:
    """Yield joints that nothing keeps from turning round and round."""
    if message := without_limits(robot.model):
        hint = "in MJCF: range of the joint, in a URDF: <limit>; allow it for joints that are meant to turn on and on"
        place = robot.config.place("model")
        yield Problem(message, place, hint, code="no-joint-limits", severity="warning")


def _odd_numbers(robot: RobotModel) -> Iterator[Problem]:
    """Yield a mass, and limits of a fall, that no humanoid has."""
    config = robot.config
    low, high = _MASS
    if not low < robot.mass < high:
        message = f"the robot weighs {robot.mass:.1f} kg"
        hint = f"expected: {low:g} to {high:g} kg; look at the densities and inertials of the model"
        yield Problem(message, config.place("model"), hint, code="odd-mass", severity="warning")
    for key, value, (least, most) in (
        ("tilt", config.fall.tilt, _FALL_TILT),
        ("height", config.fall.height, _FALL_HEIGHT),
    ):
        if not least <= value <= most:
            early = (value < least) == (key == "tilt")
            why = "a robot that leans counts as falling" if early else "a fall is not noticed"
            hint = f"expected: {least:g} to {most:g}"
            message = f"fall.{key} {value:g}: {why}"
            yield Problem(message, config.place("fall", key), hint, code="fall-limits", severity="warning")


def _joints_above(model: mujoco.MjModel, name: str) -> list[str]:
    """Return the hinges that move a body, from the base to it."""
    bodies = carriers(model, model.body(name).id)[::-1]
    return [
        model.joint(joint).name for body in bodies for joint in range(1, model.njnt) if model.jnt_bodyid[joint] == body
    ]


def _away(model: mujoco.MjModel, data: mujoco.MjData, name: str, point: Array) -> float:
    """Return how far a point is from what surrounds a body's geoms, or from its origin [m]."""
    body = model.body(name).id
    away = [
        float(np.linalg.norm(point - data.geom_xpos[geom])) - float(model.geom_rbound[geom])
        for geom in range(model.ngeom)
        if model.geom_bodyid[geom] == body
    ]
    return max(0.0, min([*away, float(np.linalg.norm(point - data.xpos[body]))]))


def _axis(direction: Array) -> str:
    """Return the axis that a direction is along, as ``-y``, or its numbers if it is along none."""
    most = int(np.argmax(np.abs(direction)))
    if abs(direction[most]) < _ALONG:
        return _numbers(direction)
    return ("-" if direction[most] < 0 else "") + "xyz"[most]


def _numbers(values: Array) -> str:
    return "[" + ", ".join(f"{0.0 if math.isclose(value, 0, abs_tol=5e-4) else value:.3f}" for value in values) + "]"


def _wider_than_said(robot: RobotModel, data: mujoco.MjData) -> Iterator[Problem]:
    """Yield that the standing robot sticks out of the circle within which it is said to walk."""
    config = robot.config
    middle = np.mean([data.site(sole_site(side)).xpos[:2] for side in SIDES], axis=0)
    reaches = [
        (
            float(np.linalg.norm((data.xpos[one.body] + data.xmat[one.body].reshape(3, 3) @ end)[:2] - middle))
            + one.radius,
            one,
        )
        for one in capsules(robot)
        for end in one.ends
    ]
    reach, widest = max(reaches, key=lambda found: found[0], default=(0.0, None))
    if widest is not None and reach > config.walking_radius:
        name = robot.model.body(widest.body).name
        message = (
            f"{name!r} is {reach:.2f} m from the middle between the feet, walking_radius {config.walking_radius:g} m"
        )
        hint = f"walking_radius: {reach + _SWAY:.2f}  # m, with room for sway; nearer things would be bumped into"
        yield Problem(message, config.place("walking_radius"), hint, code="walking-radius", severity="warning")
