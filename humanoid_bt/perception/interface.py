"""What an engine asks of perception, whatever sees: a source, several of them, or a test that dictates."""

from __future__ import annotations

import abc
import types
from collections.abc import Collection, Mapping, Sequence

from humanoid_bt.core.clock import PERCEPTION_PERIOD
from humanoid_bt.core.messages import Level, Percept, State, Truth

OLDEST = 60.0
"""How long ago something may have been seen that is told of only now [s]: so long it is known where the robot stood."""

NOTHING: Mapping[str, str] = types.MappingProxyType({})


class Perception(abc.ABC):
    """What sees. Whoever derives from it has to say only what it observes.

    Attributes:
        period: how often it is to be asked [s].
        names: the percepts that it may publish.
        unseen: the percepts that it offers and never published so far, and why, as of the last look. For people, in a
            few words: ``hidden``, ``out of range: 4.1 m away, seen up to 3 m``.
    """

    period: float = PERCEPTION_PERIOD
    names: Collection[str] = ()

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that were never published so far, and why."""
        return NOTHING

    def start(self) -> None:  # noqa: B027 (most have nothing to begin)
        """Begin, before the first look; raises UserError if it cannot."""

    @abc.abstractmethod
    def observe(self, robot: Truth, state: State | None = None) -> Sequence[Percept]:
        """Return what is published now: once per period.

        Args:
            robot: where the robot really is.
            state: what control believes, None if nobody knows.
        """

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what happened to it since the last time: how much it matters, and a line of text."""
        return ()

    def close(self) -> None:  # noqa: B027 (most have nothing to end)
        """End what it started."""
