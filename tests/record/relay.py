"""A slow way to a port: what it sends stays on the way until it is let through."""

from __future__ import annotations

import contextlib
import socket
import threading
from typing import Self

LOOPBACK = "127.0.0.1"


class Relay:
    """Passes one connection on to a port, and back only the first bytes of what comes until it is opened.

    Args:
        target: the port.
        first: bytes that pass before it is opened.

    Attributes:
        port: where it listens.
        reached: set once the first bytes have passed.
        opened: set to let the rest through.
    """

    def __init__(self, target: int, first: int) -> None:
        self._target, self._first = target, first
        self._listener = socket.create_server((LOOPBACK, 0))
        self.port = self._listener.getsockname()[1]
        self.reached, self.opened = threading.Event(), threading.Event()

    def __enter__(self) -> Self:
        threading.Thread(target=self._serve, daemon=True).start()
        return self

    def __exit__(self, *_: object) -> None:
        self.opened.set()
        self._listener.close()

    def _serve(self) -> None:
        with contextlib.suppress(OSError):
            while True:
                client, _ = self._listener.accept()
                server = socket.socket()
                server.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 14)  # the rest stays with the sender
                server.connect((LOOPBACK, self._target))
                threading.Thread(target=self._forth, args=(client, server), daemon=True).start()
                threading.Thread(target=self._back, args=(server, client), daemon=True).start()

    def _forth(self, client: socket.socket, server: socket.socket) -> None:
        with contextlib.suppress(OSError):
            while data := client.recv(1 << 14):
                server.sendall(data)

    def _back(self, server: socket.socket, client: socket.socket) -> None:
        passed = 0
        with contextlib.suppress(OSError):
            while data := server.recv(1 << 14):
                client.sendall(data)
                passed += len(data)
                if passed >= self._first:
                    self.reached.set()
                    self.opened.wait()
        with contextlib.suppress(OSError):
            client.shutdown(socket.SHUT_RDWR)
