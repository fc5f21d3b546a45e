"""A first ``robot.yaml`` for a model: what was found in it, and marked with ``guessed`` what it does not say."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
import yaml

from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.core.patterns import matches, matching
from humanoid_bt.core.texts import listed
from humanoid_bt.files.formatting import formatted
from humanoid_bt.robot.config import GaitConfig, RobotConfig
from humanoid_bt.robot.footprint import footprint_in
from humanoid_bt.robot.survey.drives import drive, falling, usual_stiffness, without_limits
from humanoid_bt.robot.survey.facing import doubts
from humanoid_bt.robot.survey.limbs import Limb, NoHumanoidError, Surveyor, corners, roles
from humanoid_bt.robot.survey.places import eyes, looks_down, palm
from humanoid_bt.robot.survey.posture import home, overlapping
from humanoid_bt.robot.survey.size import USUAL_MASS, first_shift, odd_size, scaled_contact, scaled_gait, spin
from humanoid_bt.robot.survey.soles import ALIGNED, angle_of, sole_axes
from humanoid_bt.robot.survey.stride import stride

_SIDE = re.compile(r"left|right|(?<![a-z])[lr](?=_)|(?<=_)[lr](?![a-z])", re.I)
_ROLES = ("hip_roll", "hip_pitch", "ankle_pitch")
_ROLL = "ankle_roll"  # which a leg may lack
_MARGIN = 0.4  # share of the sole's half width inside which the centre of pressure may be, at most the default
_DEFAULT_MARGIN = 0.012  # m
_GRIP = 0.2  # share of the half length from toe and heel: a sole that bears at its end grips there only, and pivots
_NARROWER = 0.85  # of the distance of the hips: feet that stand so turn less under a leg that swings
_NEARER = 0.05  # m that feet may come nearer than they stand
_BETWEEN = 0.06  # m between narrow soles, which may come nearer still: a step across catches pushes to the other side
_LIGHT = 10.0  # N, below which a force has more digits
_WEIGHT_SHARE, _GRAVITY = 0.12, 9.81  # of the weight, that tells that a foot has landed
_ZERO = 5e-4  # m
_GAP = 0.01  # m between feet side by side
_POINT = 0.005  # m, half of a sole's length or width, up to which nothing can stand on it
_LEAST_TURN = 0.05  # rad that a step turns, also on hips that turn one way only
_ANKLE = 0.15  # m at most from a sole up to the frame of its foot: that of a leg of one link is at the hip
_SWAY = 0.08  # m that a walking robot reaches farther than a standing one
_WIDE = 100  # characters of a line of a comment
_STRIDES = {
    "toe_off": "in long steps feet leave by the toe",
    "heel_strike": "and land by the heel",
    "rise": "in long steps the body is higher, on straighter knees",
}


@dataclass(frozen=True)
class Description:
    """What ``robot.yaml`` is to say.

    Attributes:
        text: the file's.
        found: what was found, line by line, for people.
        guessed: what the model does not say, likewise.
        missing: what the engine needs and the model does not have.
    """

    text: str
    found: tuple[str, ...]
    guessed: tuple[str, ...]
    missing: tuple[str, ...]


def describe(model: mujoco.MjModel, name: str, file: str) -> Description:
    """Return the description of a robot.

    Args:
        model: of the robot alone.
        name: the robot's.
        file: the model's, as robot.yaml is to name it.

    Raises:
        NoHumanoidError: it has no free base or no two legs, its base faces backward, or it is not in metres.
    """
    return _Writer(model, name, file).description()


class _Writer:
    def __init__(self, model: mujoco.MjModel, name: str, file: str) -> None:
        self._model, self._name, self._file = model, name, file
        self._surveyor = Surveyor(model)
        if odd := odd_size(self._surveyor):
            raise NoHumanoidError(odd)
        self._limbs = self._surveyor.limbs()
        self._mass = float(model.body_subtreemass[self._limbs.base])
        self._hinges = [model.joint(j).name for j in range(model.njnt) if j != int(model.body_jntadr[self._limbs.base])]
        self._found, self._guessed, self._missing = list[str](), list[str](), list[str]()
        self._palms = {side: palm(self._surveyor, arm) for side, arm in self._limbs.arms.items()}
        self._soles = {side: sole_axes(self._surveyor, leg.body) for side, leg in self._limbs.legs.items()}
        self._doubts = doubts(self._surveyor, self._limbs, self._soles)
        palms = {side: place for side, (place, _) in self._palms.items()}
        self._home = home(self._surveyor, self._limbs, palms, self._soles)
        self._standing = mujoco.MjData(model)
        for joint, angle in self._home.items():
            self._standing.qpos[model.jnt_qposadr[joint]] = angle
        mujoco.mj_kinematics(model, self._standing)
        mujoco.mj_comPos(model, self._standing)
        self._feet = {
            side: footprint_in(model, self._standing, leg.body, self._soles[side])
            for side, leg in self._limbs.legs.items()
        }

    def description(self) -> Description:
        parts = [
            self._head(),
            self._trunk(),
            self._legs(),
            self._hands(),
            self._gaze(),
            self._drives(),
            self._posture(),
        ]
        parts += [self._groups(), self._gait(), self._whole_body(), self._contact(), self._overlap(), self._room()]
        text = "\n".join("\n".join(lines) + "\n" for lines in map(list, parts) if lines)
        return Description(
            formatted(text, "robot.yaml"), tuple(self._found), tuple(self._guessed), tuple(self._missing)
        )

    def _body(self, body: int) -> str:
        return str(self._model.body(body).name)

    def _joint(self, joint: int) -> str:
        return str(self._model.joint(joint).name)

    def _head(self) -> Iterator[str]:
        mass, joints = self._mass, len(self._hinges)
        yield "# A first description, found in the model. Look at what is marked 'guessed', then try the robot:"
        yield f"#   humanoid-bt check sim/{self._name}/robot.yaml"
        yield "# Lengths in metres, angles in radians. What else can stand here: docs/robots.md."
        yield "format: 1"
        yield f"name: {_quoted(self._name)}"
        yield f"description: {mass:.0f} kg, {joints} joints"
        if unlimited := without_limits(self._model):
            self._missing.append(f"limits in the model: {unlimited}")
            yield f"# {unlimited}. Give the model some,"
            yield "# or add a line here, if they are meant to turn on and on: '# allow no-joint-limits: why'"
        yield f"model: {_quoted(self._file)}"

    def _trunk(self) -> Iterator[str]:
        limbs = self._limbs
        self._found.append(f"base {self._body(limbs.base)}, torso {self._body(limbs.torso)}")
        base = self._body(limbs.base)
        ahead = self._guess(f"that x of {base!r} points ahead, although {self._doubts}") if self._doubts else ""
        yield f"base: {_quoted(base)}    # has the free joint{f'; {ahead}: its x points ahead' if ahead else ''}"
        yield f"torso: {_quoted(self._body(limbs.torso))}    # carries arms and head"

    def _legs(self) -> Iterator[str]:
        yield "legs:"
        halves: list[Array] = []
        by_role = {side: dict(roles(self._surveyor, leg)) for side, leg in self._limbs.legs.items()}
        self._rolls = all(_ROLL in found for found in by_role.values())
        for side, leg in self._limbs.legs.items():
            found = {role: _quoted(self._joint(joint)) for role, joint in by_role[side].items()}
            yield f"  {side}:"
            for role in _ROLES:
                if role in found:
                    yield f"    {role}: {found[role]}"
                else:
                    yield f"    # {role}: no joint of this leg was found that does it"
                    self._missing.append(f"{role} of the {side} leg")
            if _ROLL in found:
                yield f"    {_ROLL}: {found[_ROLL]}"
            else:
                yield f"    # {_ROLL}: no joint of this leg tilts the foot sideways; it balances sideways by its steps"
            foot = self._feet[side]
            centre = np.zeros(3) if foot is None else foot.centre
            if lacks := self._no_sole(side, leg):
                self._missing.append(lacks)
                yield from textwrap.wrap(
                    f"missing: {lacks}", _WIDE, initial_indent="    # ", subsequent_indent="    # "
                )
            elif foot is not None:
                halves.append(foot.half)
            place = f"position: {_vector(centre)}{_turned(self._soles[side])}"
            yield f"    sole: {{body: {_quoted(self._body(leg.body))}, {place}}}"
            tilts = "" if _ROLL in found else ", none of them tilts it sideways"
            self._found.append(f"{side} leg: {len(leg.joints)} joints, foot {self._body(leg.body)}{tilts}")
        length, width = np.min(halves, axis=0).tolist() if halves else (0.1, 0.04)
        margin = min(_DEFAULT_MARGIN, _MARGIN * width)
        self._width, self._bears = 2 * width, width - margin
        sole = f"half_length: {length:.3f}, half_width: {width:.3f}"
        note = "" if halves else f"    # {self._guess('the size of the soles')}"
        if self._rolls:
            yield f"sole: {{{sole}, margin: {max(margin, _GRIP * length):.3f}, side_margin: {margin:.3f}}}{note}"
        else:
            yield f"sole: {{{sole}, margin: {margin:.3f}}}{note}"

    def _no_sole(self, side: Side, leg: Limb) -> str:
        """Return what a foot lacks of a sole, "" if it has one."""
        foot, body = self._feet[side], self._body(leg.body)
        if foot is None:
            return f"collision geoms of the {side} foot {body}{self._untouchable(leg)}"
        if foot.half.min() >= _POINT:
            return ""
        what = "a point" if foot.half.max() < _POINT else "a line"
        return (
            f"a flat {side} foot: as the model's zero pose has it, {body} touches a floor at {what}, on which nothing"
            " balances; legs must be straight there, and feet level"
        )

    def _untouchable(self, leg: Limb) -> str:
        """Return why a foot that has geoms can touch nothing."""
        if not self._surveyor.geoms(leg.body):
            return ""
        return ": contype and conaffinity of its geoms are 0; if a scene file lets them touch a floor, name that file"

    def _hands(self) -> Iterator[str]:
        for side in SIDES:
            if side not in self._limbs.arms:
                self._found.append(f"no {side} arm: skills that command this hand will fail")
        if not self._limbs.arms:
            yield "# hands: the model has no arms"
            return
        yield "hands:    # palms"
        for side, arm in self._limbs.arms.items():
            place, source = self._palms[side]
            note = f"from {source}" if source else self._guess(f"the {side} palm's position")
            yield f"  {side}: {{body: {_quoted(self._body(arm.body))}, position: {_vector(place)}}}    # {note}"
            fingers = f", {len(arm.fingers)} of fingers" if arm.fingers else ""
            self._found.append(f"{side} arm: {len(arm.joints)} joints{fingers}, hand {self._body(arm.body)}")

    def _gaze(self) -> Iterator[str]:
        surveyor, head = self._surveyor, self._limbs.head
        body, place, source = eyes(surveyor, self._limbs)
        turns = {axis: j for j in (head.joints if head else ()) for axis in (1, 2) if surveyor.turns_about(j, axis)}
        note, angle = f"from {source}" if source else self._guess("the eyes' position"), ""
        if (down := looks_down(surveyor, self._limbs, body, place)) > 0:
            note, angle = f"{note}; down: {self._guess('how far the eyes look down')}", f", down: {down:.2f}"
        turned = _turned(self._upright(body))
        yield f"gaze: {{body: {_quoted(self._body(body))}, position: {_vector(place)}{turned}{angle}}}    # {note}"
        if set(turns) == {1, 2}:
            yaw, pitch = (_quoted(self._joint(turns[axis])) for axis in (2, 1))
            yield f"neck: {{yaw: {yaw}, pitch: {pitch}}}"
            self._found.append("neck with yaw and pitch")
        else:
            self._found.append("no neck: the torso turns the view")

    def _upright(self, body: int) -> Array:
        """Return what is ahead, left and up of a body as the robot stands, in its frame, shape (3, 3)."""
        data = self._standing
        axes: Array = data.xmat[body].reshape(3, 3).T @ data.xmat[self._limbs.base].reshape(3, 3)
        return np.eye(3) if angle_of(axes) < ALIGNED else axes

    def _drives(self) -> Iterator[str]:
        groups: dict[tuple[float, float, float], list[str]] = {}
        guessed: set[str] = set()
        falls = falling(self._surveyor, self._limbs, self._height())
        usual = usual_stiffness(self._surveyor, self._limbs, falls)
        for joint in range(self._model.njnt):
            if self._joint(joint) in self._hinges:
                found = drive(self._model, joint, usual.get(joint), falls)
                groups.setdefault((found.stiffness, found.damping, found.torque), []).append(self._joint(joint))
                guessed |= set(found.guessed)
        note = ""
        if guessed:
            which = listed([name for name in ("stiffness", "damping", "torque") if name in guessed])
            note = f"    # {self._guess(f'{which} of the drives')}: {which}"
        yield f"drives:{note}"
        for (stiffness, damping, torque), names in groups.items():
            joints = ", ".join(_quoted(pattern) for pattern in _patterns(names, self._hinges))
            numbers = f"stiffness: {stiffness:g}, damping: {damping:g}, torque: {torque:g}"
            yield f"  - {{joints: [{joints}], {numbers}}}"

    def _posture(self) -> Iterator[str]:
        angles = {self._joint(joint): angle for joint, angle in self._home.items() if angle}
        yield f"home:{'' if angles else ' {}'}    # {self._guess('the posture in which it stands')}"
        for angle in dict.fromkeys(angles.values()):
            for pattern in _patterns([name for name, other in angles.items() if other == angle], self._hinges):
                yield f"  {_quoted(pattern)}: {angle:g}"

    def _groups(self) -> Iterator[str]:
        limbs = self._limbs
        groups: dict[str, Sequence[int]] = {f"{side}_leg": leg.joints for side, leg in limbs.legs.items()}
        groups["torso"] = (*limbs.trunk, *(limbs.head.joints if limbs.head else ()))
        groups |= {f"{side}_arm": arm.joints for side, arm in limbs.arms.items()}
        groups |= {f"{side}_fingers": arm.fingers for side, arm in limbs.arms.items() if arm.fingers}
        yield "groups:    # for plots"
        for name, joints in groups.items():
            if joints:
                yield f"  {name}: [{', '.join(_quoted(self._joint(joint)) for joint in joints)}]"

    def _gait(self) -> Iterator[str]:
        left, right = (self._sole(side) for side in SIDES)
        apart, mass = float(np.linalg.norm(left - right)), self._mass
        yield f"gait:    # {self._guess('the gait')}; the defaults fit 40 kg and 1.3 m"
        stands = min(apart, max(_NARROWER * apart, self._width + _BETWEEN + _NEARER)) if self._rolls else apart
        yield f"  stance_width: {stands:.2f}"
        yield f"  separation_min: {self._separation(stands):.2f}"
        yield f"  separation_max: {apart + 0.24:.2f}"
        lands = _WEIGHT_SHARE * mass * _GRAVITY
        yield f"  touchdown_force: {lands:{'.0f' if lands >= _LIGHT else '.2g'}}"
        small = scaled_gait(self._height(), mass)
        shift = first_shift(stands, self._bears, self._height())
        usual = small.pop("first_shift", GaitConfig.first_shift)
        if shift > usual or usual < GaitConfig.first_shift:
            yield f"  first_shift: {max(shift, usual):.2f}"
        for key, value in small.items():
            yield f"  {key}: {value:.3g}"
        if (turn := self._step_turn()) < GaitConfig.step_turn:
            yield f"  step_turn: {turn:.2f}"
        strides = stride(self._surveyor, self._limbs, self._home, self._standing, self._width)
        for key, value in strides.items():
            yield f"  {key}: {value:g}    # {_STRIDES[key]}"

    def _whole_body(self) -> Iterator[str]:
        if self._rolls:
            yield f"whole_body:    # {self._guess('how firmly it keeps from spinning')}"
            yield f"  spin: {spin(self._height(), self._mass):.1f}    # arms and trunk turn against legs that swing"

    def _contact(self) -> Iterator[str]:
        if scaled := scaled_contact(self._mass):
            note = self._guess("how hard a push must be to count")
            yield f"contact:    # {note}; the defaults fit {USUAL_MASS:g} kg"
            yield from (f"  {key}: {force:.0f}" for key, force in scaled.items())

    def _step_turn(self) -> float:
        """Return by how much a step may turn: each hip by half of what it can, the rest is for pushes [rad]."""
        model, surveyor = self._model, self._surveyor
        turning = [j for leg in self._limbs.legs.values() for j in leg.joints if surveyor.turns_about(j, 2)]
        ranges = {joint: model.jnt_range[joint] - self._home[joint] for joint in turning if model.jnt_limited[joint]}
        limits = [float(np.abs(both).min()) for both in ranges.values()]
        return max(min(limits, default=math.inf), _LEAST_TURN)

    def _separation(self, stands: float) -> float:
        """Return how near feet may come that stand so far from each other [m], and do not touch then."""
        nearest = self._width + _BETWEEN if self._rolls else math.inf
        return max(stands / 2, min(stands - _NEARER, nearest), min(stands, self._width + _GAP))

    def _height(self) -> float:
        """Return how high the centre of mass is above the feet [m]."""
        feet = [
            min(self._standing.xpos[leg.body][2], self._sole(side)[2] + _ANKLE)
            for side, leg in self._limbs.legs.items()
        ]
        return float(self._standing.subtree_com[self._limbs.base][2] - min(feet))

    def _sole(self, side: Side) -> Array:
        """Return where the centre of a sole is as the robot stands, world frame, shape (3,) [m]."""
        body, foot = self._limbs.legs[side].body, self._feet[side]
        centre = np.zeros(3) if foot is None else foot.centre
        return np.asarray(self._standing.xpos[body] + self._standing.xmat[body].reshape(3, 3) @ centre)

    def _overlap(self) -> Iterator[str]:
        """Yield the links that are in what carries them, as it stands: shapes of many models do not end at a joint."""
        pairs = overlapping(self._model, self._standing.qpos)
        if pairs:
            yield "collision:"
            yield f"  overlap:    # {self._guess('links whose shapes are in each other, which do not touch')}"
            for body, others in pairs.items():
                yield f"    {_quoted(self._body(body))}: [{', '.join(_quoted(self._body(other)) for other in others)}]"

    def _room(self) -> Iterator[str]:
        """Yield the circle within which it walks, if the default is too small."""
        model, data = self._model, self._standing
        middle = np.mean([data.xpos[leg.body][:2] for leg in self._limbs.legs.values()], axis=0)
        farthest = 0.0
        for geom in range(model.ngeom):
            if model.geom_contype[geom] or model.geom_conaffinity[geom]:
                away = corners(model, data, geom)[:, :2] - middle
                farthest = max(farthest, float(np.linalg.norm(away, axis=1).max()))
        if farthest + _SWAY > RobotConfig.walking_radius:
            yield f"walking_radius: {farthest + _SWAY:.2f}    # its arms, and room for sway"

    def _guess(self, what: str) -> str:
        self._guessed.append(what)
        return "guessed"


def _patterns(names: Sequence[str], known: Sequence[str]) -> list[str]:
    """Return names, and for those of both sides one pattern where it means just these."""
    found: list[str] = []
    for name in names:
        pattern = _SIDE.sub("*", name, count=1)
        matched = matching(known, pattern)
        fits = len(matched) > 1 and set(matched) <= set(names)
        if not any(matches(name, one) for one in found):
            found.append(pattern if fits else name)
    return found


def _quoted(name: str) -> str:
    """Return a name as YAML reads it as that text, also ``no``, ``12`` and what has blanks and colons."""
    return name if re.fullmatch(r"[\w./-]+", name) and yaml.safe_load(name) == name else _in_quotes(name)


def _in_quotes(name: str) -> str:
    written: str = yaml.safe_dump(name, default_style='"', allow_unicode=True, width=math.inf)
    return written.rstrip("\n")


def _turned(axes: Array) -> str:
    """Return how axes that are not those of their body are written."""
    return "" if np.array_equal(axes, np.eye(3)) else f", ahead: {_vector(axes[:, 0])}, up: {_vector(axes[:, 2])}"


def _vector(values: Array) -> str:
    return "[" + ", ".join("0" if abs(value) < _ZERO else f"{value:.3f}" for value in values) + "]"
