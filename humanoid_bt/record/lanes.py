"""What the robot is doing, as lanes of the state timeline: mode, gait, limits."""

from __future__ import annotations

from typing import Any

import rerun as rr

from humanoid_bt.core.messages import Gait, Mode, State
from humanoid_bt.record.columns import Color, lane, send

_FREE, _LIMITED = "free", "limited"
_LOOKS: dict[str, dict[str, Color]] = {
    "mode": {
        Mode.RUN.value: (64, 180, 90),
        Mode.PROTECTIVE_STOP.value: (240, 160, 40),
        Mode.EMERGENCY_STOP.value: (232, 74, 74),
        Mode.DAMP.value: (190, 75, 219),
    },
    "gait": {
        Gait.STAND.value: (92, 99, 110),
        Gait.STEP.value: (66, 153, 245),
        Gait.SETTLE.value: (59, 120, 150),
    },
    "limits": {_FREE: (60, 66, 75), _LIMITED: (240, 160, 40)},
}
MODE_COLORS = _LOOKS["mode"]
"""Colours of the supervisor's modes, by their names."""

LANE_COUNT = len(_LOOKS)
"""Number of lanes written here; the tree's come after them."""


class RobotLanes:
    """Writes mode, gait and limits when they change."""

    def __init__(self) -> None:
        self._lanes = [lane(number, name) for number, name in enumerate(_LOOKS)]
        self._now = [""] * LANE_COUNT
        self._changes: list[list[tuple[float, str]]] = [[] for _ in _LOOKS]

    def log_static(self, stream: Any) -> None:
        """Write the looks of the states."""
        for number, colors in enumerate(_LOOKS.values()):
            states = list(colors)
            look = rr.StateConfiguration(
                values=states,
                labels=[state.replace("_", " ") for state in states],
                colors=list(colors.values()),
                visible=[state != _FREE for state in states],
            )
            stream.log(self._lanes[number], look, static=True)

    def add(self, state: State) -> None:
        """Take one state."""
        values = (state.mode.value, state.gait.value, _LIMITED if state.limit_flags else _FREE)
        for number, value in enumerate(values):
            if self._now[number] != value:
                self._now[number] = value
                self._changes[number].append((state.time, value))

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        for path, changes in zip(self._lanes, self._changes, strict=True):
            if changes:
                columns = rr.StateChange.columns(state=[value for _, value in changes])
                send(stream, path, [time for time, _ in changes], columns)
                changes.clear()
