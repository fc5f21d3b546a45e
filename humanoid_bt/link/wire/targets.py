"""Targets and their sources, as commands and states carry them."""

from __future__ import annotations

import struct
from collections.abc import Mapping

import numpy as np

from humanoid_bt.core.messages import RESOURCES, Array, BaseTarget, GazeTarget, HandTarget, PostureTarget, Target
from humanoid_bt.link.wire.format import Cursor, WireError, pack_path

_TARGET = struct.Struct("<BB3d")  # resource, type, numbers; those a type does not need are 0
_RESOURCE = struct.Struct("<B")
_INDEX = {resource: index for index, resource in enumerate(RESOURCES)}
_BASE, _HAND, _GAZE, _POSTURE = range(4)


def pack_targets(targets: Mapping[str, Target]) -> bytes:
    """Return targets one after the other; their number is not in it."""
    return b"".join([_pack_target(_index(resource), target) for resource, target in targets.items()])


def unpack_targets(cursor: Cursor, count: int) -> dict[str, Target]:
    """Return a number of targets."""
    targets: dict[str, Target] = {}
    for _ in range(count):
        resource, kind, x, y, z = cursor.take(_TARGET)
        targets[_resource(resource, targets)] = _target(kind, x, y, z)
    return targets


def pack_sources(sources: Mapping[str, str]) -> bytes:
    """Return the sources of targets one after the other; their number is not in it."""
    return b"".join([_RESOURCE.pack(_index(resource)) + pack_path(path) for resource, path in sources.items()])


def unpack_sources(cursor: Cursor, count: int) -> dict[str, str]:
    """Return a number of sources."""
    sources: dict[str, str] = {}
    for _ in range(count):
        (resource,) = cursor.take(_RESOURCE)
        sources[_resource(resource, sources)] = cursor.text()
    return sources


def _pack_target(resource: int, target: Target) -> bytes:
    match target:
        case BaseTarget(position=position, heading=heading):
            x, y = _numbers(position, 2)
            return _TARGET.pack(resource, _BASE, x, y, heading)
        case HandTarget(position=position):
            return _TARGET.pack(resource, _HAND, *_numbers(position, 3))
        case GazeTarget(point=position):
            return _TARGET.pack(resource, _GAZE, *_numbers(position, 3))
        case PostureTarget(height=height):
            return _TARGET.pack(resource, _POSTURE, height, 0.0, 0.0)
    raise WireError(f"{type(target).__name__} is no target")


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
