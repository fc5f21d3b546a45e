"""Where the robot really is, on the wire."""

from __future__ import annotations

import struct

import numpy as np

from humanoid_bt.core.messages import Truth
from humanoid_bt.link.wire.format import Cursor, MessageKind, guarded, header, pack_floats

_FLOATS = 3 + 4 + 3 + 3
_JOINTS = struct.Struct("<H")


@guarded("this truth cannot be encoded")
def encode_truth(truth: Truth) -> bytes:
    """Return where the robot really is as bytes.

    Raises:
        WireError: an array has the wrong shape.
    """
    arrays = truth.base_position, truth.base_quaternion, truth.gaze_position, truth.gaze_direction
    joints = len(truth.joint_positions)
    return b"".join(
        (
            header(MessageKind.TRUTH, 0, truth.time),
            pack_floats(np.concatenate(arrays), _FLOATS),
            _JOINTS.pack(joints),
            pack_floats(truth.joint_positions, joints),
        )
    )


@guarded("malformed truth")
def decode_truth(data: bytes | memoryview) -> Truth:
    """Return where the robot really is, as bytes say.

    Raises:
        WireError: they hold nothing of it.
    """
    cursor = Cursor(data, MessageKind.TRUTH)
    floats = cursor.floats(_FLOATS).copy()  # aligned
    floats.flags.writeable = False
    (count,) = cursor.take(_JOINTS)
    joints = cursor.floats(int(count)).copy()
    joints.flags.writeable = False
    cursor.end()
    return Truth(cursor.header.stamp, floats[:3], floats[3:7], floats[7:10], floats[10:], joints)
