"""What perception says, on the wire."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

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
_COUNT = struct.Struct("<I")
_MAX_WHY = 512  # bytes, its size included


class Sight(NamedTuple):
    """What perception says of one look: the percepts, and why others were never published so far."""

    percepts: Sequence[Percept]
    unseen: Mapping[str, str]


def percepts_room(names: Iterable[str]) -> int:
    """Return the most bytes that the percepts of these names take."""
    header_size, each = 64, _NUMBERS.size + 3 * FLOAT.itemsize + _MAX_WHY
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
    parts.append(_COUNT.pack(len(unseen)))
    for name, why in unseen.items():
        parts += [pack_text(name), pack_cut_text(why, _MAX_WHY - 2)]
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
    (count,) = cursor.take(_COUNT)
    unseen = {cursor.text(): cursor.text() for _ in range(int(count))}
    cursor.end()
    return Sight(percepts, unseen)
