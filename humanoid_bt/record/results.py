"""What skills report: a time series for each result that is a number, to the value at the skill's end."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np
import rerun as rr

from humanoid_bt.decision.result import Reported
from humanoid_bt.record.batch import Batch
from humanoid_bt.record.columns import entity, scalars, send
from humanoid_bt.record.plots import LEGEND, PALETTE

RESULTS = "results"
KINDS = {"m": "lengths", "rad": "angles"}
"""SI unit to where its series stand below :data:`RESULTS`."""

OTHERS = "others"
"""Where those of other units, or of none, stand."""

_Series = tuple[str, str, str]  # path of the node, name, unit


class ResultSeries:
    """Collects results and writes them in batches."""

    def __init__(self) -> None:
        self._rows: Batch[tuple[_Series, float, float]] = Batch("results")  # with time [s] and value
        self._begun: set[str] = set()  # entities whose series have names in the recording

    def add(self, time: float, path: str, results: Sequence[Reported]) -> None:
        """Take what a skill has set by now; texts are left aside.

        Args:
            time: engine time [s].
            path: the node's path.
            results: what it has set.
        """
        for name, value, unit in results:
            if not isinstance(value, str):
                self._rows.append(((path, name, unit), time, float(value)))

    def flush(self, stream: Any) -> None:
        """Write what was added since the last flush."""
        self._rows.draw(partial(self._draw, stream))

    def _draw(self, stream: Any, rows: Sequence[tuple[_Series, float, float]]) -> None:
        found: dict[_Series, tuple[list[float], list[float]]] = {}
        for key, time, value in rows:
            times, values = found.setdefault(key, ([], []))
            times.append(time)
            values.append(value)
        for (path, name, unit), (times, values) in found.items():
            series = entity(RESULTS, KINDS.get(unit, OTHERS), path, name)
            if series not in self._begun:
                color = PALETTE[len(self._begun) % len(PALETTE)]
                label = f"{path.rsplit('/', 1)[-1]}: {name.replace('_', ' ')}" + (f" [{unit}]" if unit else "")
                legend = entity(RESULTS, LEGEND, path, name)
                for curve in (series, legend):
                    stream.log(curve, rr.SeriesLines(names=[label], colors=[color]), static=True)
                send(stream, legend, times[:1], scalars(np.array([np.nan])), lasting=True)
                self._begun.add(series)
            send(stream, series, times, scalars(np.array(values)))
