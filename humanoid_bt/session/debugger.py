"""Standing still between two ticks: who paused a run, and what may go on."""

from __future__ import annotations

from collections import deque

from humanoid_bt.core.messages import Pause
from humanoid_bt.core.texts import shortened
from humanoid_bt.session.teller import Teller


class Debugger:
    """Says before every tick of one run whether the tree may have it.

    What is asked for holds at once, from any thread; it is told, as an event, when the run comes to it.

    Args:
        teller: is told who did what.

    Attributes:
        pause: who wants the tree to stand still, and why; None while it goes on.
    """

    def __init__(self, teller: Teller) -> None:
        self._teller = teller
        self.pause: Pause | None = None
        self._steps = 0  # ticks that a paused tree may still have
        self._news: deque[str] = deque()

    def ask_pause(self, source: str, reason: str) -> None:
        """Let the tree stand still from the next tick on; who asked first stays the one who did."""
        if self.pause is None:
            self.pause = pause = Pause(shortened(source), shortened(reason))
            self._news.append(str(pause))

    def resume(self, source: str) -> None:
        """Let the tree go on."""
        if self.pause is not None:
            self.pause, self._steps = None, 0
            self._news.append(f"continued by {source}")

    def ask_step(self, source: str) -> None:
        """Let a paused tree have one tick; one that goes on is paused."""
        if self.pause is None:
            self.ask_pause(source, "to go on step by step")
        else:
            self._steps += 1

    def standing(self) -> Pause | None:
        """Return why there is no tick now, None if there is one; it takes a step that was asked for."""
        if self._steps and self.pause is not None:
            self._steps -= 1
            return None
        return self.pause

    def tell(self) -> None:
        """Tell what was asked for since the last time."""
        while self._news:
            self._teller.event("info", self._news.popleft())
