"""Handing bytes to another process: at once and never waiting, or waiting for it, but not for ever."""

from __future__ import annotations

import select
import socket
from collections import deque

_BUFFER = 1 << 20  # bytes that the system is asked to keep under way; it may give less


class Stuck(Exception):  # noqa: N818 (the name says it)
    """The other process took nothing for too long."""


class Outbox:
    """What is under way to another process, in order.

    Args:
        end: this process's end of a stream.
        patience: how long the other process may take nothing [s]; 0 to never wait for it: what it does not take yet
            stays here, and goes on its way with what comes next.

    Attributes:
        size: bytes that stay here.
    """

    def __init__(self, end: socket.socket, patience: float) -> None:
        end.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _BUFFER)
        end.setblocking(False)
        self._end, self._patience = end, patience
        self._waiting: deque[bytes] = deque()
        self.size = 0

    def put(self, message: bytes, patience: float | None = None) -> None:
        """Hand over a message.

        Args:
            message: what it is.
            patience: another one, for once [s].

        Raises:
            Stuck: it took nothing for too long.
            OSError: nobody is there any more.
        """
        if message:
            self._waiting.append(message)
        self.size += len(message)
        self.push(patience)

    def push(self, patience: float | None = None) -> None:
        """Hand over what stays here, as far as it is taken.

        Args:
            patience: another one, for once [s].

        Raises:
            Stuck: it took nothing for too long.
            OSError: nobody is there any more.
        """
        patience = self._patience if patience is None else patience
        while self._waiting:
            try:
                taken = self._end.send(self._waiting[0])
            except BlockingIOError:
                if not patience:
                    return
                _wait_for_room(self._end, patience)
                continue
            self.size -= taken
            if taken < len(self._waiting[0]):
                self._waiting[0] = self._waiting[0][taken:]
            else:
                self._waiting.popleft()


def _wait_for_room(end: socket.socket, patience: float) -> None:
    poll = select.poll()
    poll.register(end, select.POLLOUT)
    if not poll.poll(1000 * patience):
        raise Stuck
