"""What a node says, put into words only when somebody asks: in most ticks nobody does."""

from __future__ import annotations

from collections.abc import Callable


class ToldWhenAsked:
    """Base of nodes that say something in every tick, of values that change from tick to tick."""

    _said: str | Callable[[], str] = ""

    @property
    def feedback_message(self) -> str:
        """What it says."""
        return self._said if isinstance(self._said, str) else self._said()

    @feedback_message.setter
    def feedback_message(self, said: str) -> None:
        self._said = said

    def say(self, words: Callable[[], str]) -> None:
        """Say what this returns when somebody asks."""
        self._said = words
