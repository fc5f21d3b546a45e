"""A cable that is worse than it is: later, less regular, with losses, or pulled."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from humanoid_bt.cable.address import Address
from humanoid_bt.cable.cables import Cable

_NANO = 1e9


@dataclass(frozen=True)
class Impairment:
    """What happens to frames on their way, in each direction.

    Attributes:
        latency: that every frame takes [s].
        jitter: that it takes longer at most, evenly distributed [s].
        loss: share of the frames that never arrive.
    """

    latency: float = 0.0
    jitter: float = 0.0
    loss: float = 0.0


class ImpairedCable:
    """One end of a cable that delays and loses frames of both directions.

    Args:
        cable: the real one.
        impairment: what becomes of frames.
        now: the time [ns].
        grain: time between two looks [ns]; a frame goes on at the look that is nearest to when it is due.
        random: decides.

    Attributes:
        pulled: nothing gets through, in either direction.
    """

    def __init__(
        self,
        cable: Cable,
        impairment: Impairment,
        now: Callable[[], int],
        grain: int,
        random: np.random.Generator,
    ) -> None:
        self._cable, self._impairment, self._now, self._random = cable, impairment, now, random
        self._early = grain // 2
        self._going: list[tuple[int, int, bytes, Address]] = []  # due, number, frame, where to
        self._coming: list[tuple[int, int, bytes, Address]] = []
        self._count = 0
        self.pulled = False

    def send(self, frame: bytes, to: Address) -> None:
        """Send a frame some time."""
        self._put(self._going, frame, to)

    def receive(self) -> list[tuple[bytes, Address]]:
        """Send what is due; return what has come by now."""
        self.move()
        return self._due(self._coming)

    def move(self) -> None:
        """Let frames go on that are due; call it more often than frames come, for delays to be as they are meant."""
        for frame, sender in self._cable.receive():
            self._put(self._coming, frame, sender)
        for frame, to in self._due(self._going):
            self._cable.send(frame, to)

    def close(self) -> None:
        """Let everything go that was sent, and close the cable."""
        while self._going and not self.pulled:
            _, _, frame, to = heapq.heappop(self._going)
            self._cable.send(frame, to)
        self._cable.close()

    def _put(self, frames: list[tuple[int, int, bytes, Address]], frame: bytes, peer: Address) -> None:
        lost, share = self._random.random(2).tolist()
        if self.pulled or lost < self._impairment.loss:
            return
        delay = self._impairment.latency + share * self._impairment.jitter
        self._count += 1
        heapq.heappush(frames, (self._now() + round(delay * _NANO), self._count, frame, peer))

    def _due(self, frames: list[tuple[int, int, bytes, Address]]) -> list[tuple[bytes, Address]]:
        until, found = self._now() + self._early, []
        while frames and frames[0][0] <= until:
            _, _, frame, peer = heapq.heappop(frames)
            found.append((frame, peer))
        return found
