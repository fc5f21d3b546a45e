"""A tick of decision as it was, to the bit: what it saw, what it commanded, how long it took."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from dataclasses import dataclass

from humanoid_bt.core.messages import Command, Percept, State
from humanoid_bt.link.wire import (
    WireError,
    decode_command,
    decode_percepts,
    decode_state,
    encode_command,
    encode_percepts,
    encode_state,
)
from humanoid_bt.link.wire.percepts import Sight

_HEADER = struct.Struct("<dIII")  # how long it took [s]; bytes of state, percepts, command


@dataclass(frozen=True, slots=True)
class Tick:
    """One tick.

    Attributes:
        state: what control knew.
        percepts: what was perceived since the tick before.
        command: what was commanded, None if a node raised an exception.
        took: how long the tree took, on the wall clock [s].
    """

    state: State
    percepts: Sequence[Percept] = ()
    command: Command | None = None
    took: float = 0.0

    def encode(self) -> bytes:
        """Return it as bytes.

        Raises:
            WireError: it holds something that the wire cannot carry.
        """
        state = encode_state(self.state)
        percepts = encode_percepts(Sight(self.percepts, {})) if self.percepts else b""
        command = encode_command(self.command) if self.command is not None else b""
        return _HEADER.pack(self.took, len(state), len(percepts), len(command)) + state + percepts + command

    @classmethod
    def decode(cls, data: bytes) -> Tick:
        """Return the tick that bytes hold.

        Raises:
            WireError: they hold none.
        """
        took, state, _, command = _parts(data)
        return cls(decode_state(state), percepts_of(data), decode_command(command) if command else None, took)


def percepts_of(data: bytes) -> Sequence[Percept]:
    """Return what was perceived since the tick before the one that bytes hold.

    Raises:
        WireError: they hold none.
    """
    percepts = _parts(data)[2]
    return decode_percepts(percepts).percepts if percepts else ()


def state_of(data: bytes) -> State:
    """Return the state of the tick that bytes hold.

    Raises:
        WireError: they hold none.
    """
    return decode_state(_parts(data)[1])


def _parts(data: bytes) -> tuple[float, bytes, bytes, bytes]:
    try:
        took, *sizes = _HEADER.unpack_from(data)
    except struct.error:
        raise WireError(f"{len(data)} bytes are too short for a tick") from None
    state, percepts = _HEADER.size + sizes[0], _HEADER.size + sizes[0] + sizes[1]
    if percepts + sizes[2] != len(data):
        raise WireError(f"a tick of {percepts + sizes[2]} bytes in {len(data)}")
    return took, data[_HEADER.size : state], data[state:percepts], data[percepts:]
