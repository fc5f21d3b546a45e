"""What perception says, on the wire."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from humanoid_bt.core.messages import Percept
from humanoid_bt.link.wire.format import Cursor, MessageKind, guarded, header, pack_floats, pack_text

_NUMBERS = struct.Struct("<dd")  # stamp, confidence


@guarded("these percepts cannot be encoded")
def encode_percepts(percepts: Sequence[Percept]) -> bytes:
    """Return percepts as bytes.

    Raises:
        WireError: a position has the wrong shape.
    """
    parts = [header(MessageKind.PERCEPTS, len(percepts), max((percept.stamp for percept in percepts), default=0.0))]
    for percept in percepts:
        parts.append(pack_text(percept.name))
        parts.append(_NUMBERS.pack(percept.stamp, percept.confidence))
        parts.append(pack_floats(percept.position, 3))
    return b"".join(parts)


@guarded("malformed percepts")
def decode_percepts(data: bytes | memoryview) -> list[Percept]:
    """Return the percepts that bytes hold.

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
    cursor.end()
    return percepts
