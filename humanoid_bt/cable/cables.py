"""What carries frames: UDP, or memory where both ends are in one process."""

from __future__ import annotations

import errno
import socket
from collections import deque
from contextlib import suppress
from typing import Protocol

from humanoid_bt.cable.address import Address
from humanoid_bt.core.errors import HumanoidBtError, UserError

_LARGEST = 65_535  # bytes of a datagram
_AT_ONCE = 256  # datagrams that one look takes: a flood must not hold up the servo
_ROOM = 1 << 20  # bytes that wait in the kernel: 0.6 s of commands


class Cable(Protocol):
    """One end of a cable. Frames may come late, out of order, twice, or never."""

    def send(self, frame: bytes, to: Address) -> None:
        """Send a frame; whether it arrives is not known. Never waits."""

    def receive(self) -> list[tuple[bytes, Address]]:
        """Return what came since the last time, and from where. Never waits."""

    def close(self) -> None:
        """Let go of it."""


class UdpCable:
    """A socket.

    Args:
        address: where it listens; None: anywhere, as a driver does, which nobody needs to find.
        peer: the other end, where ``address`` is None.

    Raises:
        UserError: another listens there, or nobody can.
    """

    def __init__(self, address: Address | None = None, peer: Address | None = None) -> None:
        host = (address or peer or Address("127.0.0.1", 0)).host
        self._socket = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _ROOM)
        if address is None:
            if peer is not None and peer.is_local:  # then nobody else needs to reach it
                self._socket.bind((peer.host, 0))
            return
        try:
            self._socket.bind((address.host, address.port))
        except OSError as error:
            self._socket.close()
            if error.errno == errno.EADDRINUSE:
                hint = "end that one, or give another port with --listen"
                raise UserError(f"another plant, or another program, listens at {address}", hint=hint) from error
            raise UserError(f"nobody can listen at {address}: {error.strerror}") from error

    def send(self, frame: bytes, to: Address) -> None:
        """Send a frame. A cable that is pulled is noticed by what does not come."""
        with suppress(OSError):
            self._socket.sendto(frame, to)

    def receive(self) -> list[tuple[bytes, Address]]:
        """Return what came."""
        found = []
        with suppress(OSError):  # nothing more is there
            for _ in range(_AT_ONCE):
                data, sender = self._socket.recvfrom(_LARGEST)
                found.append((data, Address(sender[0], sender[1])))
        return found

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class MemoryNetwork:
    """Cables within one process: what is sent is there at once."""

    def __init__(self) -> None:
        self._inboxes: dict[Address, deque[tuple[bytes, Address]]] = {}

    def cable(self, address: Address) -> Cable:
        """Return the cable of an address.

        Raises:
            HumanoidBtError: it has one already.
        """
        if address in self._inboxes:
            raise HumanoidBtError(f"{address} is taken")
        self._inboxes[address] = deque()
        return self.end(address)

    def end(self, address: Address) -> Cable:
        """Return a further end at an address, as of somebody who pretends to be there."""
        return _MemoryCable(self._inboxes, address)


class _MemoryCable:
    def __init__(self, inboxes: dict[Address, deque[tuple[bytes, Address]]], address: Address) -> None:
        self._inboxes, self._address = inboxes, address

    def send(self, frame: bytes, to: Address) -> None:
        if (inbox := self._inboxes.get(to)) is not None:
            inbox.append((frame, self._address))

    def receive(self) -> list[tuple[bytes, Address]]:
        inbox = self._inboxes.get(self._address, deque())
        found = list(inbox)
        inbox.clear()
        return found

    def close(self) -> None:
        self._inboxes.pop(self._address, None)
