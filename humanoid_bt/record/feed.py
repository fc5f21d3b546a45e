"""What is recorded, on its way to every stream that takes it: the file's, and the one of who watches."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pyarrow as pa

from humanoid_bt.record.columns import time_column


class Feed:
    """Several rerun streams as one.

    What holds until something takes its place is kept, for a stream that comes later: everything static, and of some
    entities the last row.
    """

    def __init__(self) -> None:
        self._streams: list[Any] = []
        self._static: list[tuple[str, tuple[Any, ...]]] = []
        self._last: dict[str, list[_LastRow]] = {}

    def add(self, stream: Any, time: float = 0.0) -> None:
        """Send to one more stream, which begins with what holds at an engine time [s]."""
        for path, what in self._static:
            stream.log(path, *what, static=True)
        for path, columns in self._last.items():
            stream.send_columns(path, [time_column([time])], columns)
        self._streams.append(stream)

    def remove(self, stream: Any) -> None:
        """Send no more to a stream."""
        self._streams.remove(stream)

    def log(self, path: str, *what: Any, static: bool = False) -> None:
        """Write an entity, as ``RecordingStream.log``."""
        if static:
            self._static.append((path, what))
        for stream in self._streams:
            stream.log(path, *what, static=static)

    def send_columns(self, path: str, indexes: Iterable[Any], columns: Iterable[Any], *, lasting: bool = False) -> None:
        """Write rows of an entity, as ``RecordingStream.send_columns``.

        Args:
            path: the entity.
            indexes: the times of the rows.
            columns: what is in them.
            lasting: whether the last row holds until the next one, however long that takes.
        """
        if lasting:
            self._last[path] = [_LastRow(column) for column in columns]
        for stream in self._streams:
            stream.send_columns(path, indexes, columns)


class _LastRow:
    """The last row of a column, as a column."""

    def __init__(self, column: Any) -> None:
        self._descriptor, self._array = column.component_descriptor(), column.as_arrow_array()[-1:]

    def component_descriptor(self) -> Any:
        return self._descriptor

    def as_arrow_array(self) -> pa.Array:
        return self._array
