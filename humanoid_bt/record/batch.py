"""What is drawn at once, because that costs a tenth; what of it cannot be drawn costs no more than itself."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from humanoid_bt.core.texts import told

_T = TypeVar("_T")

_log = logging.getLogger(__name__)


class Batch(Generic[_T]):
    """Items in the order of time.

    Args:
        what: they show, for people.
    """

    def __init__(self, what: str) -> None:
        self._what, self._told = what, False
        self._items: list[_T] = []

    def append(self, item: _T) -> None:
        """Take one more."""
        self._items.append(item)

    def draw(self, *draws: Callable[[Sequence[_T]], None]) -> None:
        """Draw them in each of these ways and begin anew; where that fails one by one, without those that fail."""
        items, self._items = self._items, []
        for draw in draws if items else ():
            try:
                draw(items)
            except Exception:
                for item in items:
                    self._draw_alone(item, draw)

    def _draw_alone(self, item: _T, draw: Callable[[Sequence[_T]], None]) -> None:
        try:
            draw([item])
        except Exception as error:
            if not self._told:  # once: it may be so in every tick of hours
                self._told = True
                _log.warning("something of %s cannot be drawn, and is left out: %s", self._what, told(error))
