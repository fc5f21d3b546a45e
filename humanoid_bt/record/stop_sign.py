"""A stop in the 3D view: a coloured disc under the robot and the reason above it, as long as the stop lasts."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import rerun as rr

from humanoid_bt.core.messages import Mode, State
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import send_sets
from humanoid_bt.record.lanes import MODE_COLORS
from humanoid_bt.record.scene_view import WORLD
from humanoid_bt.record.tree_view import printable

DISC, RIM, REASON = (f"{WORLD}/stop/{part}" for part in ("disc", "rim", "reason"))

_RADIUS = 0.6  # of the disc [base heights]
_ABOVE = 2.15  # height of the reason [base heights]
_LIFT = 0.003  # the disc lies this far above the floor, below what else lies there [m]
_THICKNESS = 0.001  # of the disc [m]
_ALPHA = 110  # of the disc, in which feet and footsteps stay visible
_CIRCLE = np.stack([(np.cos(a), np.sin(a), 0.0) for a in np.linspace(0, 2 * np.pi, 49)])


class StopSign:
    """Shows when, how and why one robot was stopped.

    Args:
        base_height: of the standing robot [m], the measure of the sign.
    """

    def __init__(self, base_height: float) -> None:
        self._base_height = base_height
        self._states: Batch[State] = Batch("stops")
        self._shown = False

    def log_static(self, stream: Any) -> None:
        """Write what never changes: sizes and looks."""
        frame = rr.CoordinateFrame(WORLD)
        stream.log(DISC, frame, rr.Cylinders3D.from_fields(fill_mode=rr.components.FillMode.Solid), static=True)
        stream.log(RIM, frame, rr.LineStrips3D.from_fields(radii=[0.02 * self._base_height]), static=True)
        stream.log(REASON, frame, rr.Points3D.from_fields(radii=[0.0], show_labels=True), static=True)

    def add(self, state: State) -> None:
        """Take one state; a robot that goes on costs nothing."""
        stopped = state.mode is not Mode.RUN
        if stopped or self._shown:
            self._states.append(state)
        self._shown = stopped

    def flush(self, stream: Any) -> None:
        """Write what was added since the last flush."""
        self._states.draw(partial(self._draw, stream))

    def _draw(self, stream: Any, states: Sequence[State]) -> None:
        times = [state.time for state in states]
        stops = [state for state in states if state.mode is not Mode.RUN]
        counts = [int(state.mode is not Mode.RUN) for state in states]
        floor = np.array([[*state.base_position[:2], _LIFT] for state in stops]).reshape(-1, 3)
        colors = [MODE_COLORS[state.mode.value] for state in stops]
        radius = _RADIUS * self._base_height
        discs = rr.Cylinders3D.columns(
            lengths=[_THICKNESS] * len(stops),
            radii=[radius] * len(stops),
            centers=floor,
            colors=[(*color, _ALPHA) for color in colors],
        )
        rims = rr.LineStrips3D.columns(strips=list(floor[:, None] + radius * _CIRCLE), colors=colors)
        reasons = rr.Points3D.columns(
            positions=floor + np.array([0.0, 0.0, _ABOVE * self._base_height]),
            colors=colors,
            labels=[printable(_text(state)) for state in stops],
        )
        for path, columns in ((DISC, discs), (RIM, rims), (REASON, reasons)):
            send_sets(stream, path, times, columns, counts)


def _text(state: State) -> str:
    return f"{state.mode.value.replace('_', ' ').upper()}\n{state.stop_reason}"
