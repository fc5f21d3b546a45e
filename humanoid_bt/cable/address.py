"""Where a plant is: addresses as people write them, and the key that others than this machine need."""

from __future__ import annotations

import ipaddress
import os
import socket
import stat
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit

from humanoid_bt.core.errors import UserError

PORT = 4747
"""Where a plant listens if nobody says so."""

_SHORTEST_KEY = 16  # bytes
_LONGEST_KEY = 4096


class Address(NamedTuple):
    """An end of the cable.

    Attributes:
        host: its number, such as 127.0.0.1.
        port: of UDP.
    """

    host: str
    port: int

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        return f"udp://{host}:{self.port}"

    @property
    def is_local(self) -> bool:
        """Whether only this machine reaches it."""
        return ipaddress.ip_address(self.host).is_loopback


def read_address(text: str) -> Address:
    """Return the address that a text names: ``udp://HOST:PORT``, ``HOST:PORT`` or ``HOST``.

    Raises:
        UserError: it names none.
    """
    hint = f"valid: udp://HOST:PORT, such as udp://127.0.0.1:{PORT}"
    scheme, mark, rest = text.partition("://")
    if mark and scheme != "udp":
        raise UserError(f"a plant is not reached by {scheme!r}: {text!r}", hint=hint)
    try:
        parts = urlsplit(f"//{rest if mark else text}")
        host, port = parts.hostname, PORT if parts.port is None else parts.port
        if not host or parts.path or parts.query or parts.username:
            raise ValueError
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except socket.gaierror as error:
        raise UserError(f"there is no host {host!r}: {error.strerror}", hint=hint) from error
    except (ValueError, UnicodeError) as error:
        raise UserError(f"{text!r} is no address", hint=hint) from error
    hosts = [str(one[4][0]) for one in sorted(found, key=lambda one: one[0] != socket.AF_INET)]  # "localhost" is both
    return Address(hosts[0], port)


def read_key(address: Address, path: Path | None) -> bytes | None:
    """Return the key for frames to or from an address, None where a checksum is enough: on this machine.

    Raises:
        UserError: the address needs a key, or the file holds none that only its owner can read.
    """
    make = "make one with: (umask 077; head -c 32 /dev/urandom > plant.key), and give it to both sides"
    if path is None:
        if address.is_local:
            return None
        raise UserError(f"{address} can be reached from other machines: its frames need a key (--key FILE)", hint=make)
    try:
        descriptor = os.open(path, os.O_RDONLY)
        with os.fdopen(descriptor, "rb") as file:
            mode = os.fstat(descriptor).st_mode
            key = file.read(_LONGEST_KEY + 1) if stat.S_ISREG(mode) else b""
    except OSError as error:
        raise UserError(f"the key {str(path)!r} cannot be read: {error.strerror}", hint=make) from error
    if mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise UserError(f"others than its owner can reach the key {str(path)!r}", hint=f"chmod 600 {path}")
    if not _SHORTEST_KEY <= len(key) <= _LONGEST_KEY:
        message = f"the key {str(path)!r} must have {_SHORTEST_KEY} to {_LONGEST_KEY} bytes"
        raise UserError(message, hint=make)
    return key
