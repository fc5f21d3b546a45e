"""The event log: what happened in the run, and every node's change of status with its reason."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import rerun as rr

from humanoid_bt.core.errors import HumanoidBtError, nearest
from humanoid_bt.core.messages import Level
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import send
from humanoid_bt.record.names import short_names
from humanoid_bt.record.tree_view import printable
from humanoid_bt.tree.show.looks import STATUS_GLYPHS
from humanoid_bt.tree.show.outline import Outline

__all__ = ["EVENTS", "SHOWN", "EventLog", "Level"]

EVENTS = "events"
SHOWN = ("CRITICAL", "ERROR", "WARN", "INFO")
"""The levels that the viewer shows until somebody asks for more."""

_LEVELS = {"info": "INFO", "warning": "WARN", "error": "ERROR"}
_LEAVES = ("skill", "action", "condition")


class _Line(NamedTuple):
    time: float
    level: str
    text: str
    node: str  # path of the node that it is about


class EventLog:
    """Collects lines and writes them in batches.

    What skills, actions and conditions do has level INFO. DEBUG is what follows from it: what the nodes above them
    do, and that a branch is left in which nothing ran.
    """

    def __init__(self, outline: Outline) -> None:
        self._lines: Batch[_Line] = Batch("events")
        self.show(outline)

    def show(self, outline: Outline) -> None:
        """Take the tree whose nodes change from now on."""
        self._names = short_names(outline)
        self._leaves = {node.path for node in outline.nodes if node.kind in _LEAVES}

    def event(self, time: float, level: Level, text: str) -> None:
        """Take something that happened in the run.

        Raises:
            HumanoidBtError: there is no such level.
        """
        if level not in _LEVELS:
            raise HumanoidBtError(f"no event level {level!r}; {nearest(level, _LEVELS)}")
        self._lines.append(_Line(time, _LEVELS[level], printable(text), ""))

    def node_changed(self, time: float, path: str, status: str, feedback: str) -> None:
        """Take a node's change of status."""
        told = path in self._leaves and (feedback or status != "INVALID")
        text = f"{STATUS_GLYPHS[status]} {self._names[path]}" + (f": {feedback}" if feedback else "")
        self._lines.append(_Line(time, "INFO" if told else "DEBUG", printable(text), path))

    def flush(self, stream: Any) -> None:
        """Write the lines since the last flush."""
        self._lines.draw(partial(_draw, stream))


def _draw(stream: Any, lines: Sequence[_Line]) -> None:
    times, levels, texts, paths = zip(*lines, strict=True)
    columns = rr.TextLog.columns(text=texts, level=levels)
    nodes = rr.AnyValues.columns(node=[printable(path) for path in paths])
    send(stream, EVENTS, times, [*columns, *nodes])
