"""The limbs of a humanoid, found in its model by where they are and about what their joints turn; names are hints."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import mujoco
import numpy as np

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import SIDES, Array, Side
from humanoid_bt.robot.model import carriers

_ALONG = 0.7  # cosine between a joint's axis and x, y or z of the base: hips are often a little oblique
_ASIDE = 0.02  # m from the middle from which something is on a side
_UNEVEN = 0.2  # m that one foot may be from the mirror image of the other
_LOW = 0.1  # of a robot's height that its feet may be above what is lowest of it
_TOES = 0.02  # m that a foot may end above its toes
_ARM_JOINTS = 3  # that an arm has at least
_FINGER = re.compile(r"finger|thumb|gripper|jaw|claw", re.IGNORECASE)
_OUTWARD: dict[Side, float] = {"left": 1.0, "right": -1.0}


class NoHumanoidError(HumanoidBtError):
    """The model is none of a humanoid: the text says what is missing, and where it was looked for."""


@dataclass(frozen=True)
class Limb:
    """A leg, an arm or a head.

    Attributes:
        body: at its end: foot, hand or head.
        joints: from the trunk to that body; of an arm without those of the fingers.
        fingers: joints beyond that body.
        origin: body that carries the first of the joints.
    """

    body: int
    joints: tuple[int, ...]
    fingers: tuple[int, ...] = ()
    origin: int = 0


@dataclass(frozen=True)
class Limbs:
    """A humanoid's.

    Attributes:
        base: body with the free joint.
        torso: body that carries arms and head.
        trunk: joints between base, torso and legs that belong to none of them.
        legs, arms: by side; arms may be missing.
        head: None if it has no joints of its own.
    """

    base: int
    torso: int
    trunk: tuple[int, ...]
    legs: dict[Side, Limb]
    arms: dict[Side, Limb] = field(default_factory=dict)
    head: Limb | None = None


class Surveyor:
    """Looks at a model in its reference posture (qpos0), in the frame of its base: x ahead, y left, z up.

    Args:
        model: of the robot alone.

    Raises:
        NoHumanoidError: there is not exactly one free joint.

    Attributes:
        model, data: MuJoCo's, with kinematics.
        base: body with the free joint.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        free = [j for j in range(model.njnt) if model.jnt_type[j] == mujoco.mjtJoint.mjJNT_FREE]
        if len(free) != 1:
            has = "none" if not free else ", ".join(repr(model.body(model.jnt_bodyid[j]).name) for j in free)
            raise NoHumanoidError(f"the model must have one free joint, on the body that is its base; it has {has}")
        self.model, self.data = model, mujoco.MjData(model)
        mujoco.mj_kinematics(model, self.data)
        self.base = int(model.jnt_bodyid[free[0]])
        self._children: dict[int, list[int]] = {body: [] for body in range(model.nbody)}
        for body in range(1, model.nbody):
            if model.body_weldid[body] == body:  # what is fixed to another body belongs to it
                self._children[int(model.body_weldid[model.body_parentid[body]])].append(body)

    def limbs(self) -> Limbs:
        """Return the robot's limbs.

        Raises:
            NoHumanoidError: it has no two legs.
        """
        feet = self._feet()
        ways = {side: self._way(foot) for side, foot in feet.items()}
        shared = set(ways["left"]) & set(ways["right"])
        legs: dict[Side, Limb] = {side: self._limb(foot, shared) for side, foot in feet.items()}
        leg_bodies = set(ways["left"]) ^ set(ways["right"])
        torso, arms = self._arms(leg_bodies)
        limbs = {body for limb in arms.values() for body in self._subtree(self._first(limb))}
        head = self._head(torso, leg_bodies | limbs)
        taken = {joint for limb in (*legs.values(), *arms.values(), head) if limb for joint in limb.joints}
        trunk = tuple(j for body in {*self._way(torso), *shared} for j in self._joints(body) if j not in taken)
        return Limbs(self.base, torso, tuple(sorted(trunk)), legs, arms, head)

    def place(self, body: int) -> Array:
        """Return where a body is, in the base's frame, shape (3,) [m]."""
        return self.seen(self.data.xpos[body])

    def seen(self, point: Array) -> Array:
        """Return a point of the world in the base's frame, shape (..., 3) [m]."""
        return np.asarray((point - self.data.xpos[self.base]) @ self.data.xmat[self.base].reshape(3, 3))

    def axis(self, joint: int) -> Array:
        """Return the axis of a joint in the base's frame, shape (3,)."""
        return np.asarray(self.data.xaxis[joint] @ self.data.xmat[self.base].reshape(3, 3))

    def turns_about(self, joint: int, axis: int) -> bool:
        """Return whether a joint turns about (0: x, 1: y, 2: z), either way round."""
        return bool(abs(self.axis(joint)[axis]) >= _ALONG)

    def geoms(self, body: int) -> list[int]:
        """Return the geoms of a body and of those fixed to it."""
        owners = self.model.body_weldid[self.model.geom_bodyid]
        return np.flatnonzero(owners == self.model.body_weldid[body]).tolist()

    def extent(self) -> tuple[Array, Array]:
        """Return the lowest and the highest coordinates of the robot in the base's frame, each of shape (3,) [m]."""
        model, data = self.model, self.data
        robot = [body for body in range(model.nbody) if self.base in carriers(model, body)]
        geoms = np.flatnonzero(np.isin(model.geom_bodyid, robot)).tolist()
        points = [data.xpos[robot], *(corners(model, data, geom) for geom in geoms)]
        seen = self.seen(np.concatenate(points))
        return seen.min(axis=0), seen.max(axis=0)

    def _feet(self) -> dict[Side, int]:
        """Return the lowest of the bodies at the end on either side."""
        ends = [body for body in self._subtree(self.base) if not self._children[body] and self._joints(body)]
        found: dict[Side, int] = {}
        for side in SIDES:
            beside = [body for body in ends if self.place(body)[1] * _OUTWARD[side] > _ASIDE]
            if not beside:
                base = self.model.body(self.base).name
                message = f"no leg is on the {side} side of {base!r}: x must point ahead, y to the left, z up"
                raise NoHumanoidError(message)
            found[side] = self._above_toes(min(beside, key=self._lowest))
        left, right = (self.place(foot) for foot in found.values())
        uneven = float(np.linalg.norm(left * [1, -1, 1] - right)) > _UNEVEN
        if max(left[2], right[2]) > 0 and (root := self._bare_root()):
            raise NoHumanoidError(root)
        if max(left[2], right[2]) > 0 or uneven or not self._upright(found.values()):
            names = " and ".join(repr(self.model.body(foot).name) for foot in found.values())
            base = self.model.body(self.base).name
            message = f"the lowest ends on either side of {base!r}, {names}, are no pair of feet below it"
            frame = "in its frame x must point ahead, y to the left, z up"
            raise NoHumanoidError(f"{message}: {frame}; and the robot must stand upright, on two legs")
        return found

    def _bare_root(self) -> str:
        """Return that the base is a frame and no part of the robot, as a ``base_footprint`` is, "" if it is none."""
        model, base = self.model, self.base
        fixed = [body for body in range(base + 1, model.nbody) if model.body_weldid[body] == base]
        if model.body_mass[base] or not fixed:
            return ""
        heaviest = max(fixed, key=lambda body: float(model.body_mass[body]))
        root, pelvis = (repr(model.body(body).name) for body in (base, heaviest))
        return f"the base, {root}, weighs nothing and is not above the feet: make {pelvis}, on it, the model's root"

    def _upright(self, feet: Iterable[int]) -> bool:
        """Return whether the robot is higher than it is long, and its feet are lowest: so it is in any posture."""
        low, high = self.extent()
        long, _, height = (high - low).tolist()
        return bool(height > long and min(map(self._lowest, feet)) < low[2] + _LOW * height)

    def _above_toes(self, end: int) -> int:
        """Return the body at the end of a leg, or the foot that it is the toes of: one that is as low as they are."""
        foot = int(self.model.body_weldid[self.model.body_parentid[end]])
        touches = [g for g in self.geoms(foot) if self.model.geom_contype[g] or self.model.geom_conaffinity[g]]
        if foot != self.base and touches and self._lowest(foot) < self._lowest(end) + _TOES:
            return foot
        return end

    def _lowest(self, body: int) -> float:
        """Return how high the lowest geom of a body is, roughly, or its origin if it has none."""
        low = [self.seen(self.data.geom_xpos[g])[2] - self.model.geom_rbound[g] for g in self.geoms(body)]
        return float(min([*low, self.place(body)[2]]))

    def _arms(self, legs: set[int]) -> tuple[int, dict[Side, Limb]]:
        """Return the first body from the base on that carries arms, and the arms; without any, the heaviest one.

        Both arms may begin in the middle, as with collar bones; one alone that does so is more of the trunk.
        """
        trunk = self._trunk(legs)
        for least, others in ((len(SIDES), legs), (1, legs | set(trunk))):
            for body in trunk:
                arms = self._arms_at(body, others)
                if len(arms) >= least:
                    return body, arms
        return max(trunk, key=self._weight), {}

    def _arms_at(self, body: int, others: set[int]) -> dict[Side, Limb]:
        """Return the arms that begin at a body, which are none of the others."""
        limbs = [self._hand(child) for child in self._children[body] if child not in others]
        long = [limb for limb in limbs if len(limb.joints) >= _ARM_JOINTS]
        return {side: limb for side in SIDES for limb in long if self.place(limb.body)[1] * _OUTWARD[side] > _ASIDE}

    def _weight(self, body: int) -> float:
        """Return the mass of a body and of those fixed to it [kg]."""
        owners = self.model.body_weldid
        return float(self.model.body_mass[owners == owners[body]].sum())

    def _trunk(self, legs: set[int]) -> list[int]:
        """Return the bodies in the middle from the base up, none of a leg; the head may be among them."""
        found = [self.base]
        for body in found:
            middle = [c for c in self._children[body] if c not in legs and abs(self.place(c)[1]) < _ASIDE]
            found += [c for c in middle if not legs & set(self._subtree(c))]
        return found

    def _hand(self, first: int) -> Limb:
        """Return the arm that begins with a body: the hand is where it ends, or where fingers begin.

        Where there is more than one they are told by that; one alone, of a gripper, by its name.
        """
        joints, body = list(self._joints(first)), first
        while len(self._children[body]) == 1:
            (beyond,) = self._children[body]
            names = [self.model.joint(joint).name for joint in self._joints(beyond)]
            if len(joints) >= _ARM_JOINTS and any(map(_FINGER.search, names)):
                break
            body = beyond
            joints += self._joints(body)
        fingers = [j for child in self._children[body] for part in self._subtree(child) for j in self._joints(part)]
        return Limb(body, tuple(joints), tuple(fingers), int(self.model.body_parentid[first]))

    def _head(self, torso: int, taken: set[int]) -> Limb | None:
        """Return what turns in the middle above the torso."""
        for child in self._children[torso]:
            parts = self._subtree(child)
            joints = tuple(j for part in parts for j in self._joints(part))
            if child not in taken and joints and abs(self.place(parts[-1])[1]) < _ASIDE:
                return Limb(parts[-1], joints, (), torso)
        return None

    def _limb(self, end: int, shared: set[int]) -> Limb:
        way = [body for body in self._way(end) if body not in shared]
        return Limb(
            end, tuple(j for body in way for j in self._joints(body)), (), int(self.model.body_parentid[way[0]])
        )

    def _first(self, limb: Limb) -> int:
        return int(self.model.jnt_bodyid[limb.joints[0]])

    def _way(self, body: int) -> list[int]:
        """Return the bodies from below the base to a body that joints move."""
        above = carriers(self.model, body)[::-1]
        return [part for part in above[above.index(self.base) + 1 :] if self._joints(part)]

    def _subtree(self, body: int) -> list[int]:
        found = [body]
        for part in found:
            found += self._children[part]
        return found

    def _joints(self, body: int) -> Sequence[int]:
        first = int(self.model.body_jntadr[body])
        hinges = range(first, first + int(self.model.body_jntnum[body])) if first >= 0 else ()
        return [j for j in hinges if self.model.jnt_type[j] != mujoco.mjtJoint.mjJNT_FREE]


def corners(model: mujoco.MjModel, data: mujoco.MjData, geom: int) -> Array:
    """Return the corners of the box around a geom, world frame, shape (8, 3) [m]."""
    signs = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    box = model.geom_aabb[geom][:3] + signs * model.geom_aabb[geom][3:]
    return np.asarray(data.geom_xpos[geom] + box @ data.geom_xmat[geom].reshape(3, 3).T)


def roles(surveyor: Surveyor, leg: Limb) -> Iterator[tuple[str, int]]:
    """Yield the roles of a leg's joints that it has: hip_roll, hip_pitch, ankle_pitch, ankle_roll."""
    rolls = [j for j in leg.joints if surveyor.turns_about(j, 0)]
    pitches = [j for j in leg.joints if surveyor.turns_about(j, 1)]
    if rolls:
        yield "hip_roll", rolls[0]
    if pitches:
        yield "hip_pitch", pitches[0]
    if len(pitches) > 1:
        yield "ankle_pitch", pitches[-1]
    if len(rolls) > 1:
        yield "ankle_roll", rolls[-1]
