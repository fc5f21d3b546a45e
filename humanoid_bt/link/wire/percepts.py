"""What perception says, on the wire."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from humanoid_bt.core.messages import Array, Percept
from humanoid_bt.link.wire.format import (
    FLOAT,
    Cursor,
    MessageKind,
    guarded,
    header,
    pack_cut_text,
    pack_floats,
    pack_text,
)

_NUMBERS = struct.Struct("<dd")  # stamp, confidence
_COUNTS = struct.Struct("<HHHHH")  # why others are unseen; boxes, orientations, classes, covariances
_BOX = struct.Struct("<I4d")  # index of the percept; its size, its heading
_ORIENTATION = struct.Struct("<I4d")  # index of the percept; wxyz
_INDEX = struct.Struct("<I")  # of the percept, before the text of its class
_COVARIANCE = struct.Struct("<I9d")  # index of the percept; row by row
_MAX_WHY = 512  # bytes, its size included
_MAX_CLASS = 256  # bytes, its size included


class Sight(NamedTuple):
    """What perception says of one look: the percepts, and why others were never published so far."""

    percepts: Sequence[Percept]
    unseen: Mapping[str, str]


def percepts_room(names: Iterable[str]) -> int:
    """Return the most bytes that the percepts of these names take."""
    parts = (_NUMBERS, _BOX, _ORIENTATION, _INDEX, _COVARIANCE)
    header_size, each = 64, sum(part.size for part in parts) + 3 * FLOAT.itemsize + _MAX_WHY + _MAX_CLASS
    return header_size + sum(each + len(pack_text(name)) for name in names)


@guarded("these percepts cannot be encoded")
def encode_percepts(sight: Sight) -> bytes:
    """Return what perception says as bytes.

    Raises:
        WireError: a position has the wrong shape.
    """
    percepts, unseen = sight
    parts = [header(MessageKind.PERCEPTS, len(percepts), max((percept.stamp for percept in percepts), default=0.0))]
    for percept in percepts:
        parts.append(pack_text(percept.name))
        parts.append(_NUMBERS.pack(percept.stamp, percept.confidence))
        parts.append(pack_floats(percept.position, 3))
    numbered = list(enumerate(percepts))
    boxes = [(index, box, percept.heading) for index, percept in numbered if (box := percept.size) is not None]
    turns = [(index, turn) for index, percept in numbered if (turn := percept.orientation) is not None]
    classes = [(index, percept.class_name) for index, percept in numbered if percept.class_name]
    covariances = [(index, spread) for index, percept in numbered if (spread := percept.covariance) is not None]
    parts.append(_COUNTS.pack(len(unseen), len(boxes), len(turns), len(classes), len(covariances)))
    for name, why in unseen.items():
        parts += [pack_text(name), pack_cut_text(why, _MAX_WHY - 2)]
    parts += [_BOX.pack(index, *box.tolist(), heading) for index, box, heading in boxes]
    parts += [_ORIENTATION.pack(index, *turn.tolist()) for index, turn in turns]
    parts += [_INDEX.pack(index) + pack_cut_text(name, _MAX_CLASS - 2) for index, name in classes]
    parts += [_COVARIANCE.pack(index, *spread.ravel().tolist()) for index, spread in covariances]
    return b"".join(parts)


@guarded("malformed percepts")
def decode_percepts(data: bytes | memoryview) -> Sight:
    """Return what perception says in bytes.

    Raises:
        WireError: they hold none.
    """
    cursor = Cursor(data, MessageKind.PERCEPTS)
    percepts = []
    for _ in range(cursor.header.sequence):
        name = cursor.text()
        stamp, confidence = cursor.take(_NUMBERS)
        position = cursor.floats(3).copy()  # aligned
        position.flags.writeable = False
        percepts.append(Percept(name, stamp, position, confidence))
    count, boxes, turns, classes, covariances = map(int, cursor.take(_COUNTS))
    unseen = {cursor.text(): cursor.text() for _ in range(count)}
    for _ in range(boxes):
        index, *size, heading = cursor.take(_BOX)
        percepts[int(index)] = replace(percepts[int(index)], size=_kept(size), heading=heading)
    for _ in range(turns):
        index, *turn = cursor.take(_ORIENTATION)
        percepts[int(index)] = replace(percepts[int(index)], orientation=_kept(turn))
    for _ in range(classes):
        (index,) = cursor.take(_INDEX)
        percepts[int(index)] = replace(percepts[int(index)], class_name=cursor.text())
    for _ in range(covariances):
        index, *spread = cursor.take(_COVARIANCE)
        percepts[int(index)] = replace(percepts[int(index)], covariance=_kept(spread, (3, 3)))
    cursor.end()
    return Sight(percepts, unseen)


def _kept(values: Sequence[float], shape: tuple[int, ...] = (-1,)) -> Array:
    """Return numbers as an array that nobody can write into."""
    array = np.array(values, dtype=float).reshape(shape)
    array.setflags(write=False)
    return array
