"""What the robot is doing, as lanes of the state timeline: mode, gait, limits."""

from __future__ import annotations

from typing import Any

import rerun as rr

from humanoid_bt.messages import Gait, Mode, State
from humanoid_bt.record.columns import Color, send

LANES = "robot/state"

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


class RobotLanes:
    """Writes mode, gait and limits when they change."""

    def __init__(self) -> None:
        self._now: dict[str, str] = {}
        self._changes: dict[str, list[tuple[float, str]]] = {lane: [] for lane in _LOOKS}

    def log_static(self, stream: Any) -> None:
        """Write the looks of the states."""
        for lane, colors in _LOOKS.items():
            states = list(colors)
            look = rr.StateConfiguration(
                values=states,
                labels=[state.replace("_", " ") for state in states],
                colors=list(colors.values()),
                visible=[state != _FREE for state in states],
            )
            stream.log(f"{LANES}/{lane}", look, static=True)

    def add(self, state: State) -> None:
        """Take one state."""
        self._set(state.time, "mode", state.mode.value)
        self._set(state.time, "gait", state.gait.value)
        self._set(state.time, "limits", _LIMITED if state.limit_flags else _FREE)

    def flush(self, stream: Any) -> None:
        """Write the changes since the last flush."""
        for lane, changes in self._changes.items():
            if changes:
                columns = rr.StateChange.columns(state=[value for _, value in changes])
                send(stream, f"{LANES}/{lane}", [time for time, _ in changes], columns)
                changes.clear()

    def _set(self, time: float, lane: str, value: str) -> None:
        if self._now.get(lane) != value:
            self._now[lane] = value
            self._changes[lane].append((time, value))
