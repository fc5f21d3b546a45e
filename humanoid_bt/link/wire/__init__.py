"""Messages to bytes and back: compact, every float64 exact to the bit, and never a pickle.

Every message begins with the same header (:func:`peek`). Decoding takes bytes from anywhere and answers what is
malformed with :class:`WireError` only. Decoded arrays are read-only.
"""

from humanoid_bt.link.wire.command import decode_command, encode_command
from humanoid_bt.link.wire.event import Event, Level, decode_event, encode_event
from humanoid_bt.link.wire.format import MAX_PATH, MAX_TEXT, Header, MessageKind, WireError, peek
from humanoid_bt.link.wire.percepts import Sight, decode_percepts, encode_percepts, percepts_room
from humanoid_bt.link.wire.picture import SeenPicture, decode_picture, encode_picture, picture_room
from humanoid_bt.link.wire.state import decode_state, encode_state, state_room
from humanoid_bt.link.wire.truth import decode_truth, encode_truth

__all__ = [
    "MAX_PATH",
    "MAX_TEXT",
    "Event",
    "Header",
    "Level",
    "MessageKind",
    "SeenPicture",
    "Sight",
    "WireError",
    "decode_command",
    "decode_event",
    "decode_percepts",
    "decode_picture",
    "decode_state",
    "decode_truth",
    "encode_command",
    "encode_event",
    "encode_percepts",
    "encode_picture",
    "encode_state",
    "encode_truth",
    "peek",
    "percepts_room",
    "picture_room",
    "state_room",
]
