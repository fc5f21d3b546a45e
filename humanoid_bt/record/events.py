"""The event log: what happened in the run, and every node's change of status with its reason."""

from __future__ import annotations

from typing import Any

import rerun as rr

from humanoid_bt.core.errors import HumanoidBtError, nearest
from humanoid_bt.core.messages import Level
from humanoid_bt.record.columns import Color, send
from humanoid_bt.record.tree_view import printable
from humanoid_bt.tree.show.looks import STATUS_COLORS, STATUS_GLYPHS

__all__ = ["EVENTS", "EventLog", "Level"]

EVENTS = "events"

_LEVELS: dict[str, tuple[str, Color]] = {
    "info": ("INFO", (200, 205, 212)),
    "warning": ("WARN", (240, 160, 40)),
    "error": ("ERROR", (232, 74, 74)),
}
_NODE_LEVEL = "DEBUG"  # the viewer filters by level: node changes can be hidden at a click
_SOURCES = ("run", "tree")


class EventLog:
    """Collects lines and writes them in batches."""

    def __init__(self) -> None:
        self._lines: dict[str, list[tuple[float, str, str, Color]]] = {source: [] for source in _SOURCES}

    def event(self, time: float, level: Level, text: str) -> None:
        """Take something that happened in the run.

        Raises:
            HumanoidBtError: there is no such level.
        """
        if level not in _LEVELS:
            raise HumanoidBtError(f"no event level {level!r}; {nearest(level, _LEVELS)}")
        name, color = _LEVELS[level]
        self._lines["run"].append((time, name, printable(text), color))

    def node_changed(self, time: float, path: str, status: str, feedback: str) -> None:
        """Take a node's change of status."""
        reason = f": {feedback}" if feedback else ""
        name = path.rsplit("/", 1)[-1]
        text = f"{STATUS_GLYPHS[status]} {name} {status}{reason}  ({path})"
        self._lines["tree"].append((time, _NODE_LEVEL, printable(text), STATUS_COLORS[status].dark))

    def flush(self, stream: Any) -> None:
        """Write the lines since the last flush."""
        for source, lines in self._lines.items():
            if lines:
                times, levels, texts, colors = zip(*lines, strict=True)
                columns = rr.TextLog.columns(text=texts, level=levels, color=colors)
                send(stream, f"{EVENTS}/{source}", times, columns)
                lines.clear()
