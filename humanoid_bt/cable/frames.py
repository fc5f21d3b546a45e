"""Frames on the cable: a header, a payload, and a seal that shows whether all of it is as it was sent.

A frame is one datagram. Little-endian, without padding: magic ``hp``, version, kind, how it is sealed, 3 bytes of zero,
session (u64), sequence (u64), stamp (f64 [s]); the payload of its kind; the seal: CRC-32 (4 bytes), or of those who
share a key the first 16 bytes of HMAC-SHA-256 (RFC 2104) over all that comes before it.
"""

from __future__ import annotations

import hmac
import math
import struct
from enum import IntEnum
from typing import NamedTuple
from zlib import crc32

from humanoid_bt.link.wire import WireError

VERSION = 1
"""Of the frames; both ends must have the same."""

_MAGIC = b"hp"
_HEADER = struct.Struct("<2sBBB3xQQd")  # magic, version, kind, seal, session, sequence, stamp
_CRC = struct.Struct("<I")
_MAC_SIZE = 16  # bytes of HMAC-SHA-256, which is enough for what is stale within milliseconds
_BY_CRC, _BY_KEY = 0, 1


class FrameKind(IntEnum):
    """What a frame is, and who sends it."""

    HELLO = 1  # driver: who it is, and what it takes the plant for
    WELCOME = 2  # plant: what it is; the session that counts from now on
    REFUSED = 3  # plant: why not
    COMMAND = 4  # driver: a joint command, every servo cycle
    SENSORS = 5  # plant: what its sensors say, every servo cycle
    TRUTH = 6  # plant, only a simulated one: where the robot really is, and what it has touched
    NOTE = 7  # plant: what happened
    BYE = 8  # driver: it leaves
    TARGETS = 9  # driver, only to a simulated plant: what the robot is sent to touch


class Frame(NamedTuple):
    """A frame.

    Attributes:
        kind: what it is.
        session: of which session; in a hello the number that the driver made up, so that it knows its answer.
        sequence: counts the sender's servo cycles.
        stamp: the sender's time [s].
        payload: what follows.
    """

    kind: FrameKind
    session: int
    sequence: int
    stamp: float
    payload: bytes = b""


class SealError(WireError):
    """A frame that is whole, but not sealed as those are that this end takes."""


def pack(frame: Frame, key: bytes | None = None) -> bytes:
    """Return a frame as bytes.

    Args:
        frame: the frame.
        key: with which it is sealed; None for a checksum.
    """
    kind, session, sequence, stamp, payload = frame
    seal = _BY_CRC if key is None else _BY_KEY
    body = _HEADER.pack(_MAGIC, VERSION, kind, seal, session, sequence, stamp) + payload
    return body + (_CRC.pack(crc32(body)) if key is None else _mac(key, body))


def unpack(data: bytes, key: bytes | None = None) -> Frame:
    """Return the frame that bytes hold.

    Args:
        data: from anywhere.
        key: with which it must be sealed; None for a checksum.

    Raises:
        SealError: it is not sealed with this key, or with one where none is expected.
        WireError: this is no frame.
    """
    if len(data) < _HEADER.size + _CRC.size:
        raise WireError(f"{len(data)} bytes are too short for a frame")
    magic, version, kind, seal, session, sequence, stamp = _HEADER.unpack_from(data)
    if magic != _MAGIC:
        raise WireError(f"no frame: it begins with {data[:2]!r}")
    if version != VERSION:
        raise WireError(f"a frame of version {version}, where {VERSION} is understood")
    if seal != (_BY_CRC if key is None else _BY_KEY):
        raise SealError("it is sealed with a key, and none is known here" if key is None else "it has no key")
    size = _CRC.size if key is None else _MAC_SIZE
    body, end = data[:-size], data[-size:]
    if key is None:
        if _CRC.pack(crc32(body)) != end:
            raise WireError("its checksum is wrong")
    elif not hmac.compare_digest(_mac(key, body), end):
        raise SealError("it is not sealed with this key")
    if kind not in _KINDS or not math.isfinite(stamp):
        raise WireError(f"a frame of kind {kind}, stamped {stamp}")
    return Frame(_KINDS[kind], session, sequence, stamp, body[_HEADER.size :])


_KINDS = {kind.value: kind for kind in FrameKind}


def _mac(key: bytes, body: bytes) -> bytes:
    return hmac.digest(key, body, "sha256")[:_MAC_SIZE]
