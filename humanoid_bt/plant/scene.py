"""A scene with its random numbers drawn: where things are at which time, and how they look in MuJoCo."""

from __future__ import annotations

import math
import zlib
from dataclasses import dataclass
from typing import NamedTuple

import mujoco
import numpy as np

from humanoid_bt.core.geometry import clamp
from humanoid_bt.core.messages import Array
from humanoid_bt.plant.floor import ANY, FLOOR, Floor
from humanoid_bt.plant.scene_config import EventConfig, ObjectConfig, SceneConfig, load_scene
from humanoid_bt.plant.shapes import full_size, parts
from humanoid_bt.robot.published import PLAIN

__all__ = ["Box", "Scene", "SceneConfig", "load_scene", "random_stream"]

LAMP = "hbt_lamp"
"""The light above the scene."""

_STAND_COLOR = (0.3, 0.32, 0.36, 1.0)
_POLE_RADIUS = 0.008  # m
_BASE_RADIUS = 0.09  # m; less than the distance that a robot keeps its toes from what it reaches for
_BASE_HEIGHT = 0.012  # m
_HAND_ROOM = 0.10  # m below a marker in which its pole is only drawn, so that a hand can close around the marker


def random_stream(seed: int, *key: str) -> np.random.Generator:
    """Return the random numbers of one purpose, independent of those of every other key."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=[zlib.crc32(part.encode()) for part in key]))


@dataclass(frozen=True)
class _Move:
    """A straight move of an object's centre: times [s], positions of shape (3,), world frame [m]."""

    begin: float
    end: float
    start: Array
    goal: Array

    def position(self, time: float) -> Array:
        if time >= self.end:
            return self.goal
        return np.asarray(self.start + (self.goal - self.start) * (time - self.begin) / (self.end - self.begin))


class Box(NamedTuple):
    """The upright box around a solid object.

    Attributes:
        size: length, width, height, shape (3,) [m].
        heading: of its length, world frame [rad].
        corners: from its middle, world frame, shape (8, 3) [m].
    """

    size: Array
    heading: float
    corners: Array

    def nearest(self, points: Array) -> Array:
        """Return what of the box is nearest to each of some points; both from its middle, world frame, (n, 3) [m]."""
        cos, sin = math.cos(self.heading), math.sin(self.heading)
        axes = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
        inside: Array = clamp(points @ axes, -self.size / 2, self.size / 2) @ axes.T
        return inside


class Scene:
    """What is where at which time: a pure function of the file, the seed and the time.

    Args:
        config: the scene file.
        seed: draws what the file leaves to chance; each object has its own random numbers.
        floor: what all of it stands on.

    Attributes:
        moved: the objects that the script moves.
    """

    def __init__(self, config: SceneConfig, seed: int, floor: Floor | None = None) -> None:
        self.config = config
        self.seed = seed
        self.floor = floor or Floor()
        self._events = sorted(config.events, key=lambda event: event.at)
        self._moves: dict[str, list[_Move]] = {}
        for name, thing in config.objects.items():
            self._moves[name] = [_Move(-math.inf, -math.inf, np.zeros(3), self._first_position(name, thing))]
        self._boxes = {name: self._box(name, thing) for name, thing in config.objects.items() if thing.solid}
        for event in self._events:
            if event.move is not None:
                begin = self.object_position(event.move, event.at)
                goal = np.array(event.to, dtype=float)
                self._moves[event.move].append(_Move(event.at, event.at + event.over, begin, goal))
        self.moved = [name for name, moves in self._moves.items() if len(moves) > 1]

    @property
    def start_pose(self) -> tuple[float, float, float]:
        """Where the robot stands at the beginning: x, y [m] of the middle between its feet, heading [rad], world."""
        return (*self.config.robot.position, self.config.robot.heading)

    def object_position(self, name: str, time: float) -> Array:
        """Return where an object's centre is at a time [s]: shape (3,), world frame [m].

        Raises:
            KeyError: the scene has no such object.
        """
        begun = [move for move in self._moves[name] if move.begin <= time]
        return begun[-1].position(time).copy()

    def box(self, name: str) -> Box | None:
        """Return the box around an object, wherever it is; None if it is not solid."""
        return self._boxes.get(name)

    def hidden(self, name: str, time: float) -> bool:
        """Return whether perception cannot see an object at a time [s], wherever the robot looks."""
        seen = [event for event in self._events if name in (event.hide, event.show) and event.at <= time]
        return bool(seen) and seen[-1].hide is not None

    def events(self, since: float, until: float) -> list[tuple[float, str]]:
        """Return what happens at ``since <= time < until`` [s], in order: the time and a text for people."""
        return [(event.at, _text(event)) for event in self._events if since <= event.at < until]

    def add_to(self, spec: mujoco.MjSpec) -> None:
        """Add the floor, lights and every object, as they are at time 0, to a model.

        An object is a static body ``object_<name>`` with its centre as origin; to move it, write the model's
        ``body_pos``. Its stand, a body ``stand_<name>``, stays.
        """
        _add_surroundings(spec)
        self.floor.add_to(spec, self.start_pose, random_stream(self.seed, "plates"))
        for name, thing in self.config.objects.items():
            position = self.object_position(name, 0.0)
            turn = self._heading(thing, position)
            turned = [math.cos(turn / 2), 0.0, 0.0, math.sin(turn / 2)]
            body = spec.worldbody.add_body(name=f"object_{name}", pos=position, quat=turned)
            for part in parts(thing):
                body.add_geom(
                    PLAIN,
                    name=f"{part.name} of {name}" if part.name else f"object_{name}",
                    type=part.kind,
                    size=part.size,
                    pos=part.position,
                    fromto=part.ends or [math.nan] * 6,
                    rgba=[*part.color, 1.0],
                    mass=0.0,  # it is static, and the inertia of a very small one would be none
                    contype=ANY if thing.solid else 0,
                    conaffinity=ANY if thing.solid else 0,
                )
            if thing.stand:
                _add_stand(spec, name, thing, position)

    def _heading(self, thing: ObjectConfig, position: Array) -> float:
        """Return where an object at a position faces [rad]: a person looks at where the robot starts."""
        if thing.shape != "person":
            return 0.0
        x, y, _ = self.start_pose
        return math.atan2(y - float(position[1]), x - float(position[0]))

    def _box(self, name: str, thing: ObjectConfig) -> Box:
        size, heading = np.array(full_size(thing)), self._heading(thing, self.object_position(name, 0.0))
        size.setflags(write=False)
        cos, sin = math.cos(heading), math.sin(heading)
        signs = np.array(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [-0.5, 0.5])).reshape(3, -1).T
        return Box(size, heading, size * signs @ np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]]))

    def _first_position(self, name: str, thing: ObjectConfig) -> Array:
        if thing.position is not None:
            return np.array(thing.position, dtype=float)
        place = thing.random
        if place is None:
            raise ValueError(f"the object {name!r} has no position")
        numbers = random_stream(self.seed, "object", name)
        distance = numbers.uniform(*place.distance)
        x, y, heading = self.start_pose
        direction = heading + numbers.uniform(*place.bearing)
        height = numbers.uniform(*place.height)
        return np.array([x + distance * math.cos(direction), y + distance * math.sin(direction), height])


def _text(event: EventConfig) -> str:
    if event.to is None:
        return f"{event.object} {'hidden' if event.hide else 'shown'}"
    goal = ", ".join(f"{value:g}" for value in event.to)
    return f"{event.object} moves to ({goal})" + (f" over {event.over:g} s" if event.over else "")


def _height(thing: ObjectConfig) -> float:
    return thing.size[-1]  # a ball's only number is its diameter, a person's the height; the others end with it


def _add_stand(spec: mujoco.MjSpec, name: str, thing: ObjectConfig, position: Array) -> None:
    top = float(position[2]) - _height(thing) / 2
    body = spec.worldbody.add_body(name=f"stand_{name}", pos=[position[0], position[1], 0])
    solid_top = top if thing.solid else top - _HAND_ROOM
    parts = [(0.0, _BASE_HEIGHT, _BASE_RADIUS, ANY), (_BASE_HEIGHT, solid_top, _POLE_RADIUS, ANY)]
    parts.append((max(solid_top, _BASE_HEIGHT), top, _POLE_RADIUS, 0))
    for low, high, radius, touches in parts:
        if high > low:
            body.add_geom(
                PLAIN,
                type=mujoco.mjtGeom.mjGEOM_CYLINDER,
                pos=[0, 0, (low + high) / 2],
                size=[radius, (high - low) / 2, 0],
                rgba=_STAND_COLOR,
                contype=touches,
                conaffinity=touches,
            )


def _add_surroundings(spec: mujoco.MjSpec) -> None:
    builtin, texture = mujoco.mjtBuiltin, mujoco.mjtTexture
    spec.add_texture(
        PLAIN,
        name="hbt_sky",
        type=texture.mjTEXTURE_SKYBOX,
        builtin=builtin.mjBUILTIN_GRADIENT,
        rgb1=[0.78, 0.85, 0.92],
        rgb2=[0.33, 0.42, 0.53],
        width=256,
        height=256,
    )
    spec.add_texture(
        PLAIN,
        name=FLOOR,
        type=texture.mjTEXTURE_2D,
        builtin=builtin.mjBUILTIN_CHECKER,
        rgb1=[0.45, 0.49, 0.53],
        rgb2=[0.39, 0.43, 0.47],
        width=256,
        height=256,
    )
    material = spec.add_material(PLAIN, name=FLOOR, texrepeat=[2, 2], texuniform=True)  # squares of half a meter
    material.textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = FLOOR
    spec.worldbody.add_light(
        PLAIN,
        name=LAMP,
        type=mujoco.mjtLightType.mjLIGHT_SPOT,
        pos=[2, -3, 8],
        dir=[-0.15, 0.35, -1],
        cutoff=60,
        exponent=1,
        diffuse=[0.65, 0.65, 0.65],
        specular=[0.2, 0.2, 0.2],
    )
    spec.visual.headlight.ambient = [0.35, 0.35, 0.35]
    spec.visual.headlight.diffuse = [0.4, 0.4, 0.4]
    spec.visual.quality.shadowsize = 4096
    spec.visual.global_.offwidth = max(1280, spec.visual.global_.offwidth)
    spec.visual.global_.offheight = max(960, spec.visual.global_.offheight)
