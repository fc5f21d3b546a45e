"""What perception says, on the wire."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from humanoid_bt.core.messages import Percept
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
_COUNTS = struct.Struct("<HH")  # why others are unseen; boxes, 0 in recordings from before there were any
_BOX = struct.Struct("<I4d")  # index of the percept; its size, its heading
_MAX_WHY = 512  # bytes, its size included


class Sight(NamedTuple):
    """What perception says of one look: the percepts, and why others were never published so far."""

    percepts: Sequence[Percept]
    unseen: Mapping[str, str]


def percepts_room(names: Iterable[str]) -> int:
    """Return the most bytes that the percepts of these names take."""
    header_size, each = 64, _NUMBERS.size + 3 * FLOAT.itemsize + _BOX.size + _MAX_WHY
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
    boxes = [(index, percept, box) for index, percept in enumerate(percepts) if (box := percept.size) is not None]
    parts.append(_COUNTS.pack(len(unseen), len(boxes)))
    for name, why in unseen.items():
        parts += [pack_text(name), pack_cut_text(why, _MAX_WHY - 2)]
    parts += [_BOX.pack(index, *box.tolist(), percept.heading) for index, percept, box in boxes]
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
    count, box_count = cursor.take(_COUNTS)
    unseen = {cursor.text(): cursor.text() for _ in range(int(count))}
    for _ in range(int(box_count)):
        index, *size, heading = cursor.take(_BOX)
        box = np.array(size)
        box.flags.writeable = False
        percepts[int(index)] = replace(percepts[int(index)], size=box, heading=heading)
    cursor.end()
    return Sight(percepts, unseen)
