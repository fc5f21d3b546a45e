"""Commands on the wire."""

from __future__ import annotations

import struct

from humanoid_bt.core.messages import Command
from humanoid_bt.link.wire.format import Cursor, MessageKind, guarded, header
from humanoid_bt.link.wire.targets import pack_sources, pack_targets, unpack_sources, unpack_targets

_COUNTS = struct.Struct("<BB")  # targets, sources


@guarded("this command cannot be encoded")
def encode_command(command: Command) -> bytes:
    """Return a command as bytes.

    What the supervisor refuses with a reason of its own, such as numbers that are not finite, is carried as it is.

    Raises:
        WireError: a resource is unknown, or a target has the wrong shape.
    """
    return b"".join(
        (
            header(MessageKind.COMMAND, command.sequence, command.stamp),
            _COUNTS.pack(len(command.targets), len(command.sources)),
            pack_targets(command.targets),
            pack_sources(command.sources),
        )
    )


@guarded("malformed command")
def decode_command(data: bytes | memoryview) -> Command:
    """Return the command that bytes hold.

    Raises:
        WireError: they hold none.
    """
    cursor = Cursor(data, MessageKind.COMMAND)
    targets, sources = cursor.take(_COUNTS)
    command = Command(
        cursor.header.sequence,
        cursor.header.stamp,
        unpack_targets(cursor, int(targets)),
        unpack_sources(cursor, int(sources)),
    )
    cursor.end()
    return command
