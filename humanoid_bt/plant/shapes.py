"""What objects of a scene look like, made of MuJoCo's primitives."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import mujoco

from humanoid_bt.plant.scene_config import Color, ObjectConfig

Rgb = tuple[float, float, float]
Vector = tuple[float, float, float]

COLORS: dict[Color, Rgb] = {
    "red": (0.86, 0.16, 0.15),
    "orange": (0.97, 0.5, 0.08),
    "yellow": (0.96, 0.8, 0.13),
    "green": (0.2, 0.66, 0.33),
    "blue": (0.14, 0.42, 0.86),
    "purple": (0.52, 0.28, 0.72),
    "white": (0.93, 0.93, 0.94),
    "grey": (0.5, 0.52, 0.55),
    "black": (0.1, 0.1, 0.12),
}
_PERSON_LENGTH, _PERSON_WIDTH = 0.2, 0.33  # shares of the height: shoes, and the hands beside the body
_SKIN, _HAIR, _TROUSERS, _SHOES = (0.87, 0.66, 0.53), (0.2, 0.13, 0.09), (0.2, 0.22, 0.28), (0.09, 0.09, 0.1)


class Part(NamedTuple):
    """A primitive of an object.

    Attributes:
        name: "" for the only one.
        kind: of MuJoCo's geom types.
        size: as MuJoCo takes it for the kind [m]: half lengths.
        color: red, green, blue.
        position: of its middle, from the object's, x ahead [m].
        ends: of a capsule, instead of its position: x y z of one, then of the other [m].
    """

    name: str
    kind: mujoco.mjtGeom
    size: Vector
    color: Rgb
    position: Vector = (0.0, 0.0, 0.0)
    ends: tuple[float, ...] | None = None


def parts(thing: ObjectConfig) -> Iterator[Part]:
    """Yield what an object is made of."""
    geom, color = mujoco.mjtGeom, COLORS[thing.color]
    half = [length / 2 for length in thing.size]
    match thing.shape:
        case "ball":
            yield Part("", geom.mjGEOM_SPHERE, (half[0], 0, 0), color)
        case "cylinder":
            yield Part("", geom.mjGEOM_CYLINDER, (half[0], half[1], 0), color)
        case "box":
            yield Part("", geom.mjGEOM_BOX, (half[0], half[1], half[2]), color)
        case "person":
            yield from _person(thing.size[0], color)


def full_size(thing: ObjectConfig) -> Vector:
    """Return length, width and height of the upright box around an object [m]."""
    match thing.shape:
        case "ball":
            return (thing.size[0],) * 3
        case "cylinder":
            return thing.size[0], thing.size[0], thing.size[1]
        case "box":
            return thing.size[0], thing.size[1], thing.size[2]
        case "person":
            height = thing.size[0]
            return _PERSON_LENGTH * height, _PERSON_WIDTH * height, height


def _person(height: float, clothes: Rgb) -> Iterator[Part]:
    """Yield a standing person; lengths below are shares of the height, z from the floor."""

    def place(x: float, y: float, z: float) -> Vector:
        return x * height, y * height, (z - 0.5) * height

    def lump(name: str, color: Rgb, middle: Vector, size: Vector) -> Part:
        x, y, z = (half * height for half in size)
        return Part(name, mujoco.mjtGeom.mjGEOM_ELLIPSOID, (x, y, z), color, place(*middle))

    def limb(name: str, color: Rgb, radius: float, start: Vector, end: Vector) -> Part:
        size, ends = (radius * height, 0, 0), (*place(*start), *place(*end))
        return Part(name, mujoco.mjtGeom.mjGEOM_CAPSULE, size, color, ends=ends)

    yield lump("head", _SKIN, (0.006, 0, 0.925), (0.051, 0.043, 0.066))
    yield lump("hair", _HAIR, (-0.008, 0, 0.943), (0.052, 0.049, 0.057))
    yield limb("neck", _SKIN, 0.027, (0, 0, 0.82), (0, 0, 0.87))
    yield limb("shoulders", clothes, 0.042, (0, -0.085, 0.775), (0, 0.085, 0.775))
    yield lump("chest", clothes, (0, 0, 0.69), (0.066, 0.108, 0.125))
    yield lump("belly", clothes, (0, 0, 0.58), (0.062, 0.093, 0.115))
    yield lump("hips", _TROUSERS, (0, 0, 0.495), (0.062, 0.095, 0.06))
    for side, y in (("left", 1), ("right", -1)):
        yield lump(f"{side} eye", _SHOES, (0.0515, 0.017 * y, 0.93), (0.005, 0.0065, 0.0065))
        yield limb(f"{side} upper arm", clothes, 0.028, (0, 0.118 * y, 0.77), (-0.01, 0.138 * y, 0.62))
        yield limb(f"{side} forearm", _SKIN, 0.021, (-0.01, 0.138 * y, 0.62), (0.025, 0.142 * y, 0.48))
        yield lump(f"{side} hand", _SKIN, (0.031, 0.142 * y, 0.445), (0.02, 0.014, 0.035))
        yield limb(f"{side} thigh", _TROUSERS, 0.046, (0, 0.052 * y, 0.47), (0.006, 0.055 * y, 0.29))
        yield limb(f"{side} shin", _TROUSERS, 0.036, (0.006, 0.055 * y, 0.28), (-0.006, 0.056 * y, 0.06))
        yield lump(f"{side} shoe", _SHOES, (0.024, 0.058 * y, 0.02), (0.072, 0.029, 0.02))
