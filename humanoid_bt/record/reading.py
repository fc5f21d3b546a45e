"""Reading back what a recording holds exactly: what was run, every servo cycle, every tick, everything that happened.

Whatever became of the file, cut, damaged, still being written: what is intact is read, and what is not is counted.
"""

from __future__ import annotations

import json
import math
import warnings
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from humanoid_bt.control.cycle_log import Column, Row
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.messages import Array
from humanoid_bt.link.wire import WireError
from humanoid_bt.record.packing import BlockError, unbundle, unpack
from humanoid_bt.record.tick import Tick

_ENTITY = "/flight"
_AT = 1e-7  # s; engine times are sums of floats
_STATIC = ("layout", "setup")
_BLOCKS = ("plans", "cycles", "ticks", "news")
_OLDER = "another program made it, or an older version"


class News(NamedTuple):
    """Something that happened.

    Attributes:
        time: engine time [s].
        kind: limits, node, results, event, key, unseen, input, stop, tree, end.
        value: what happened, as plain data.
    """

    time: float
    kind: str
    value: Any


@dataclass(frozen=True)
class Cycles:
    """Numbers of a recording, a row each servo cycle or each plan of the whole body.

    Attributes:
        time: engine time of each row, shape (rows,) [s].
        columns: by name, shape (rows, numbers), in the units of ``described``.
        described: what they are, with units and labels.
        damaged: how many blocks could not be read.
    """

    time: Array
    columns: dict[str, Array]
    described: dict[str, Column]
    damaged: int


@dataclass
class FlightLog:
    """What a recording holds exactly.

    Attributes:
        path: the file.
        setup: what was run, see :func:`~humanoid_bt.session.setup.run_setup`.
        layout: what the rows of plans and cycles hold.
        blocks: name -> blocks as they are in the file.
        damaged: how many blocks could not be read so far.
        cut: why the file could not be read to its end, "" if it could.
    """

    path: Path
    setup: dict[str, Any] = field(default_factory=dict)
    layout: dict[str, Any] = field(default_factory=dict)
    blocks: dict[str, list[bytes]] = field(default_factory=lambda: {name: [] for name in _BLOCKS})
    damaged: int = 0
    cut: str = ""

    def cycles(self, kind: str = "cycles", begin: float = -math.inf, end: float = math.inf) -> Cycles:
        """Return servo cycles, or with ``kind="plans"`` plans of the whole body.

        Args:
            kind: which of both.
            begin, end: engine times [s], both included.
        """
        row = self.row(kind)
        parts, damaged = [np.zeros((0, row.width))], 0
        for block in self.blocks[kind]:
            try:
                part = unpack(block, row.resolution)
            except BlockError:
                damaged += 1
                continue
            time = part[:, 0] * SERVO_PERIOD
            parts.append(part[(time >= begin - _AT) & (time <= end + _AT)])
        rows = np.concatenate(parts)
        described = {column.name: column for column in row.columns}
        return Cycles(rows[:, 0] * SERVO_PERIOD, row.split(rows), described, damaged)

    def row(self, kind: str) -> Row:
        """Return what a row of cycles or plans holds.

        Raises:
            UserError: the recording does not say.
        """
        try:
            return Row(*(Column(**{**column, "labels": tuple(column["labels"])}) for column in self.layout[kind]))
        except (KeyError, TypeError, AttributeError):
            shown = relative(self.path)
            raise UserError(f"the recording {shown!r} has no servo cycles", hint=_OLDER) from None

    def ticks(self, begin: float = -math.inf, end: float = math.inf) -> Iterator[Tick]:
        """Yield ticks, in the order of time.

        Args:
            begin, end: engine times [s], both included.
        """
        for message in self._messages("ticks"):
            try:
                tick = Tick.decode(message)
            except WireError:
                self.damaged += 1
                continue
            if begin - _AT <= tick.state.time <= end + _AT:
                yield tick

    @property
    def span(self) -> tuple[float, float]:
        """The engine times [s] of the first and the last servo cycle that the file has; both 0 if it has none."""
        time = self.cycles().time
        return (float(time[0]), float(time[-1])) if len(time) else (0.0, 0.0)

    @cached_property
    def news(self) -> list[News]:
        """Everything that happened, in the order in which it was told."""
        found = []
        for message in self._messages("news"):
            try:
                time, kind, value = json.loads(message)
                found.append(News(float(time), str(kind), value))
            except (ValueError, TypeError, RecursionError):
                self.damaged += 1
        return found

    def _messages(self, name: str) -> Iterator[bytes]:
        for block in self.blocks[name]:
            try:
                yield from unbundle(block)
            except (BlockError, zlib.error):
                self.damaged += 1


def read_flight(path: str | PathLike[str]) -> FlightLog:
    """Return what a recording holds exactly.

    Raises:
        UserError: the file is no recording of ours.
    """
    log = FlightLog(Path(path))
    try:
        for column, value in _values(log.path):
            if column in _STATIC:
                setattr(log, column, _data(value))
            else:
                log.blocks[column].append(value)
    except (RuntimeError, OSError, ValueError) as error:
        log.cut = str(error).strip().split("\n", maxsplit=1)[0]
        if not log.layout:
            raise UserError(f"{relative(log.path)!r} is no recording that can be read: {log.cut}") from error
    if not log.layout:
        raise UserError(f"the recording {relative(log.path)!r} is none of a run", hint=_OLDER)
    return log


def read_cycles(path: str | PathLike[str], kind: str = "cycles") -> Cycles:
    """Return every servo cycle of a recording, or with ``kind="plans"`` every plan of the whole body.

    Raises:
        UserError: the file is no recording, or has none of them.
    """
    return read_flight(path).cycles(kind)


def _data(text: str) -> dict[str, Any]:
    data = json.loads(text)
    return data if isinstance(data, dict) else {}


def _values(path: Path) -> Iterator[tuple[str, Any]]:
    """Yield column and value of all that is kept exactly, in the order of the file."""
    import rerun as rr  # noqa: PLC0415  # it takes half a second, and most programs read nothing

    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a recording that is still written, or was never closed
        reader = rr.chunk.RrdReader(path)
    for chunk in reader.stream():
        if chunk.entity_path == _ENTITY:
            batch = chunk.to_record_batch()
            for column in (*_STATIC, *_BLOCKS):
                if column in batch.schema.names:
                    for row in batch.column(column):
                        for value in row.as_py() or ():
                            yield column, value
