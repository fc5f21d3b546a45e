"""Consoles with colours and progress lines, on which text from elsewhere gives no commands."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import IO, Any, cast

from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment

from humanoid_bt.core.texts import printable


class SafeConsole(Console):
    """A console whose own commands reach the terminal, and nobody else's.

    Args:
        stderr: write to standard error.
        options: those of rich's console.
    """

    def __init__(self, *, stderr: bool = False, **options: Any) -> None:
        stream = sys.stderr if stderr else sys.stdout
        super().__init__(file=cast(IO[str], getattr(stream, "raw", stream)), highlight=False, **options)

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        """Yield the segments of something, made safe if they are text."""
        for segment in super().render(renderable, options):
            yield segment if segment.control else Segment(printable(segment.text), segment.style)
