"""Commands on the wire."""

from __future__ import annotations

import struct

from humanoid_bt.core.messages import Command, Pause
from humanoid_bt.link.wire.format import Cursor, MessageKind, guarded, header, pack_cut_text
from humanoid_bt.link.wire.targets import pack_sources, pack_targets, unpack_sources, unpack_targets

_COUNTS = struct.Struct("<BBB")  # targets, sources, whether it pauses

_PAUSE_ROOM = 1024  # bytes of each of its texts, so that a command fits into its slot


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
            _COUNTS.pack(len(command.targets), len(command.sources), command.pause is not None),
            pack_targets(command.targets),
            pack_sources(command.sources),
            _pack_pause(command.pause),
        )
    )


@guarded("malformed command")
def decode_command(data: bytes | memoryview) -> Command:
    """Return the command that bytes hold.

    Raises:
        WireError: they hold none.
    """
    cursor = Cursor(data, MessageKind.COMMAND)
    targets, sources, pauses = cursor.take(_COUNTS)
    command = Command(
        cursor.header.sequence,
        cursor.header.stamp,
        unpack_targets(cursor, int(targets)),
        unpack_sources(cursor, int(sources)),
        Pause(cursor.text(), cursor.text()) if pauses else None,
    )
    cursor.end()
    return command


def _pack_pause(pause: Pause | None) -> bytes:
    return b"" if pause is None else pack_cut_text(pause.source, _PAUSE_ROOM) + pack_cut_text(pause.reason, _PAUSE_ROOM)
