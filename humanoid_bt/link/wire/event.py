"""What happened, on the wire: lines for the event log."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Literal, get_args

from humanoid_bt.link.wire.format import Cursor, MessageKind, WireError, guarded, header, pack_cut_text

Level = Literal["info", "warning", "error"]

_LEVELS: tuple[Level, ...] = get_args(Level)
_LEVEL = struct.Struct("<B")


@dataclass(frozen=True, slots=True)
class Event:
    """Something that happened.

    Attributes:
        time: engine time [s].
        level: how bad it is.
        text: what it is.
    """

    time: float
    level: Level
    text: str


@guarded("this event cannot be encoded")
def encode_event(event: Event) -> bytes:
    """Return an event as bytes; a long text is cut.

    Raises:
        WireError: there is no such level.
    """
    if event.level not in _LEVELS:
        raise WireError(f"there is no level {event.level!r}; valid: {', '.join(_LEVELS)}")
    level = _LEVEL.pack(_LEVELS.index(event.level))
    return header(MessageKind.EVENT, 0, event.time) + level + pack_cut_text(event.text)


@guarded("malformed event")
def decode_event(data: bytes | memoryview) -> Event:
    """Return the event that bytes hold.

    Raises:
        WireError: they hold none.
    """
    cursor = Cursor(data, MessageKind.EVENT)
    (level,) = cursor.take(_LEVEL)
    event = Event(cursor.header.stamp, _LEVELS[int(level)], cursor.text())
    cursor.end()
    return event
