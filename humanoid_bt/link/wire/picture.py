"""A picture of the head camera on the wire."""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_bt.core.messages import Array
from humanoid_bt.link.wire.format import Cursor, MessageKind, guarded, header, pack_floats

_FLOATS = 1 + 3 + 9
_SIZE = struct.Struct("<HH")
_PIXEL = 3 + 4  # bytes: red, green, blue, and depth
_HEAD = 256  # bytes, at least, of all that is no pixel


class SeenPicture(NamedTuple):
    """A picture, and when it was taken.

    Attributes:
        time: engine time [s].
        color: shape (height, width, 3), uint8; the first row is the upper one.
        depth: along the camera's axis, shape (height, width) [m]; infinite where nothing is.
        focal: focal length [pixels].
        position: of the eye in the base frame, shape (3,) [m].
        rotation: from the eye's frame (x ahead, y left, z up) to the base frame, shape (3, 3).
    """

    time: float
    color: NDArray[np.uint8]
    depth: NDArray[np.float32]
    focal: float
    position: Array
    rotation: Array


def picture_room(width: int, height: int) -> int:
    """Return the bytes that a picture of this size takes, at most."""
    return _HEAD + width * height * _PIXEL


@guarded("this picture cannot be encoded")
def encode_picture(picture: SeenPicture) -> bytes:
    """Return a picture as bytes.

    Raises:
        WireError: an array has the wrong shape.
    """
    height, width = picture.depth.shape
    color = np.asarray(picture.color, np.uint8).reshape(height, width, 3)
    placed = np.concatenate([[picture.focal], picture.position, np.ravel(picture.rotation)])
    return b"".join(
        (
            header(MessageKind.PICTURE, 0, picture.time),
            _SIZE.pack(width, height),
            pack_floats(placed, _FLOATS),
            color.tobytes(),
            np.asarray(picture.depth, "<f4").tobytes(),
        )
    )


@guarded("malformed picture")
def decode_picture(data: bytes | memoryview) -> SeenPicture:
    """Return a picture, as bytes say.

    Raises:
        WireError: they are none.
    """
    cursor = Cursor(data, MessageKind.PICTURE)
    width, height = (int(size) for size in cursor.take(_SIZE))
    placed, count = cursor.floats(_FLOATS), width * height
    color = np.frombuffer(cursor.data, np.uint8, 3 * count, cursor.offset).reshape(height, width, 3)
    cursor.offset += color.nbytes
    depth = np.frombuffer(cursor.data, "<f4", count, cursor.offset).reshape(height, width)
    cursor.offset += depth.nbytes
    cursor.end()
    return SeenPicture(cursor.header.stamp, color, depth, float(placed[0]), placed[1:4], placed[4:].reshape(3, 3))
