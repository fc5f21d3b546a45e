"""Targets and their sources, as commands and states carry them."""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from humanoid_bt.core.messages import (
    RESOURCES,
    ArmTarget,
    Array,
    BaseTarget,
    GazeTarget,
    HandTarget,
    PalmAxis,
    Pointing,
    PostureTarget,
    Target,
)
from humanoid_bt.link.wire.format import Cursor, WireError, pack_path, pack_text

_TARGET = struct.Struct("<BB3d")  # resource, type, numbers; those a type does not need are 0
_MANNER = struct.Struct(
    "<BBB6d"
)  # of a hand: is it relative, has it a speed, how does it turn; speed, press, orientation
_JOINTS = struct.Struct("<HBd")  # of an arm: how many, has it a speed; speed
_ANGLE = struct.Struct("<d")
_RESOURCE = struct.Struct("<B")
_INDEX = {resource: index for index, resource in enumerate(RESOURCES)}
_BASE, _HAND, _GAZE, _POSTURE, _MANNERED_HAND, _ARM = range(6)
_ANY, _ORIENTATION, _FINGERS, _FACING = range(4)  # how a hand turns
_AXES: dict[PalmAxis, int] = {"fingers": _FINGERS, "facing": _FACING}


def pack_targets(targets: Mapping[str, Target]) -> bytes:
    """Return targets one after the other; their number is not in it."""
    return b"".join([_pack_target(resource, target) for resource, target in targets.items()])


def unpack_targets(cursor: Cursor, count: int) -> dict[str, Target]:
    """Return a number of targets."""
    targets: dict[str, Target] = {}
    for _ in range(count):
        resource, kind, x, y, z = cursor.take(_TARGET)
        name = _resource(resource, targets)
        if kind == _MANNERED_HAND:
            targets[name] = _unpack_hand(cursor, _fixed(x, y, z))
        else:
            targets[name] = _unpack_arm(cursor) if kind == _ARM else _target(kind, x, y, z)
    return targets


def pack_sources(sources: Mapping[str, str]) -> bytes:
    """Return the sources of targets one after the other; their number is not in it."""
    return b"".join([_pack_source(resource, path) for resource, path in sources.items()])


def unpack_sources(cursor: Cursor, count: int) -> dict[str, str]:
    """Return a number of sources."""
    sources: dict[str, str] = {}
    for _ in range(count):
        (resource,) = cursor.take(_RESOURCE)
        sources[_resource(resource, sources)] = cursor.text()
    return sources


@functools.lru_cache(64)  # the same ones in every tick, of the state and of the command
def _pack_source(resource: str, path: str) -> bytes:
    return _RESOURCE.pack(_index(resource)) + pack_path(path)


def _pack_target(resource: str, target: Target) -> bytes:
    pack = _PACKS.get(type(target))
    if pack is None:
        raise WireError(f"{type(target).__name__} is no target")
    return pack(_index(resource), target)


def _pack_base(resource: int, base: BaseTarget) -> bytes:
    x, y = _numbers(base.position, 2)
    return _TARGET.pack(resource, _BASE, x, y, base.heading)


def _pack_hand(resource: int, hand: HandTarget) -> bytes:
    place = _numbers(hand.position, 3)
    if hand.orientation is None and not hand.relative and hand.speed is None and not hand.press:
        return _TARGET.pack(resource, _HAND, *place)
    return _TARGET.pack(resource, _MANNERED_HAND, *place) + _pack_manner(hand)


def _pack_arm(resource: int, arm: ArmTarget) -> bytes:
    return _TARGET.pack(resource, _ARM, 0.0, 0.0, 0.0) + _pack_joints(arm)


def _pack_gaze(resource: int, gaze: GazeTarget) -> bytes:
    return _TARGET.pack(resource, _GAZE, *_numbers(gaze.point, 3))


def _pack_posture(resource: int, posture: PostureTarget) -> bytes:
    return _TARGET.pack(resource, _POSTURE, posture.height, 0.0, 0.0)


_PACKS: dict[type, Callable[[int, Any], bytes]] = {
    BaseTarget: _pack_base,
    HandTarget: _pack_hand,
    ArmTarget: _pack_arm,
    GazeTarget: _pack_gaze,
    PostureTarget: _pack_posture,
}


def _pack_manner(hand: HandTarget) -> bytes:
    """Return how a hand moves: what :func:`_unpack_hand` takes after its position."""
    turns, numbers = _ANY, [0.0] * 4
    match hand.orientation:
        case None:
            pass
        case Pointing(direction=direction, axis=axis):
            turns, numbers = _AXES[axis], [*_numbers(direction, 3), 0.0]
        case orientation:
            turns, numbers = _ORIENTATION, _numbers(orientation, 4)
    return _MANNER.pack(hand.relative, hand.speed is not None, turns, hand.speed or 0.0, hand.press, *numbers)


def _unpack_hand(cursor: Cursor, position: Array) -> HandTarget:
    relative, hurries, turns, speed, press, *numbers = cursor.take(_MANNER)
    if max(relative, hurries) > 1 or turns > _FACING:
        raise WireError("a hand moves in a way that there is not")
    orientation: Array | Pointing | None = None
    if turns == _ORIENTATION:
        orientation = _fixed(*numbers)
    elif turns != _ANY:
        orientation = Pointing(_fixed(*numbers[:3]), "fingers" if turns == _FINGERS else "facing")
    return HandTarget(position, orientation, bool(relative), speed if hurries else None, press)


def _pack_joints(arm: ArmTarget) -> bytes:
    head = _JOINTS.pack(len(arm.joints), arm.speed is not None, arm.speed or 0.0)
    return head + b"".join([pack_text(name) + _ANGLE.pack(angle) for name, angle in arm.joints.items()])


def _unpack_arm(cursor: Cursor) -> ArmTarget:
    count, hurries, speed = cursor.take(_JOINTS)
    if hurries > 1:
        raise WireError(f"{hurries} is no truth value")
    joints: dict[str, float] = {}
    for _ in range(int(count)):
        name = cursor.text()
        if name in joints:
            raise WireError(f"the joint {name!r} is there twice")
        joints[name] = cursor.take(_ANGLE)[0]
    return ArmTarget(joints, speed if hurries else None)


def _target(kind: float, x: float, y: float, z: float) -> Target:
    match kind:
        case 0:
            return BaseTarget(_fixed(x, y), z)
        case 1:
            return HandTarget(_fixed(x, y, z))
        case 2:
            return GazeTarget(_fixed(x, y, z))
        case 3:
            return PostureTarget(x)
    raise WireError(f"there is no target of type {kind}")


def _index(resource: str) -> int:
    index = _INDEX.get(resource)
    if index is None:
        raise WireError(f"there is no resource {resource!r}; valid: {', '.join(RESOURCES)}")
    return index


def _resource(index: float, known: Mapping[str, object]) -> str:
    if index >= len(RESOURCES):
        raise WireError(f"there is no resource of number {index}")
    resource = RESOURCES[int(index)]
    if resource in known:
        raise WireError(f"{resource!r} is there twice")
    return resource


def _numbers(values: Array, size: int) -> list[float]:
    array = np.asarray(values, float)
    if array.shape != (size,):
        raise WireError(f"a target of shape {array.shape} where ({size},) is expected")
    numbers: list[float] = array.tolist()
    return numbers


def _fixed(*values: float) -> Array:
    array = np.array(values)
    array.flags.writeable = False
    return array
