"""Rows in time for rerun: whole batches of columns, which cost a tenth of one call per value."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
import pyarrow as pa
import rerun as rr

from humanoid_bt.core.messages import Array

TIMELINE = "sim_time"
"""The one timeline: the engine's time."""

Color = tuple[int, int, int]

_SCALARS = rr.Scalars.descriptor_scalars()
_STRIP = rr.components.LineStrip3DBatch([]).as_arrow_array().type
_POINT = _STRIP.value_type


def entity(*parts: str) -> str:
    """Return the entity path of these parts, whose names may hold any characters."""
    return "/".join(rr.escape_entity_path_part(part) for part in parts)


Times: TypeAlias = Sequence[float] | Array | rr.TimeColumn
"""Engine times of rows [s], or the column that :func:`time_column` makes of them: once for many entities."""


def send(stream: Any, path: str, times: Times, columns: Any, *, lasting: bool = False) -> None:
    """Write rows of one entity.

    Args:
        stream: where they go, a :class:`~humanoid_bt.record.feed.Feed`.
        path: the entity.
        times: of the rows.
        columns: what ``Archetype.columns`` returns, one entry per row.
        lasting: whether the last row holds until the next one: a file that begins meanwhile begins with it.
    """
    index = times if isinstance(times, rr.TimeColumn) else time_column(times)
    stream.send_columns(path, [index], columns, lasting=lasting)


def send_sets(
    stream: Any, path: str, times: Times, columns: Any, lengths: Sequence[int], *, lasting: bool = False
) -> None:
    """Write rows of one entity that hold any number of instances each, none included.

    Args:
        stream: where they go, a :class:`~humanoid_bt.record.feed.Feed`.
        path: the entity.
        times: of the rows.
        columns: what ``Archetype.columns`` returns for all instances of all rows.
        lengths: number of instances of each row.
        lasting: as for :func:`send`.
    """
    send(stream, path, times, columns.partition(np.asarray(lengths)), lasting=lasting)


def time_column(times: Sequence[float] | Array) -> Any:
    """Return the index column of engine times [s]."""
    nanoseconds = np.round(np.asarray(times, dtype=float) * 1e9).astype("timedelta64[ns]")
    return rr.TimeColumn(TIMELINE, duration=nanoseconds)


def scalars(values: Array) -> Any:
    """Return what :meth:`rerun.Scalars.columns` returns, in a third of its time.

    Args:
        values: those of each row, shape (rows,) or (rows, n).
    """
    ends = np.arange(len(values) + 1, dtype=np.int32) * values[:1].size
    return [rr.ComponentColumn(_SCALARS, rr.components.ScalarBatch(values), offsets=ends)]


def strips(lines: Sequence[Any]) -> Any:
    """Return lines as :class:`rerun.LineStrips3D` takes them: at once, where it converts one after the other.

    Args:
        lines: of each the points, shape (n, 3) [m].
    """
    points = np.array([point for line in lines for point in line], np.float32).reshape(-1)
    ends = np.cumsum([0, *map(len, lines)], dtype=np.int32)
    return pa.ListArray.from_arrays(ends, pa.FixedSizeListArray.from_arrays(points, type=_POINT), type=_STRIP)


def xyzw(quaternions: Array) -> Array:
    """Return quaternions, shape (..., 4), wxyz as MuJoCo has them, in rerun's order."""
    return np.roll(quaternions, -1, axis=-1)
