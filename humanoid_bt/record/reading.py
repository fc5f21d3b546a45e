"""Reading back what a recording holds exactly: what was run, every servo cycle, every tick, everything that happened.

Whatever became of the file, cut, damaged, still being written: what is intact is read, and what is not is counted.
"""

from __future__ import annotations

import json
import math
import zlib
from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import pairwise
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from humanoid_bt.control.cycle_log import Column, Row
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.messages import Array, Percept
from humanoid_bt.link.wire import WireError
from humanoid_bt.record import shape
from humanoid_bt.record.packing import BlockError, is_whole, unbundle, unpack
from humanoid_bt.record.parts import is_recording, missing_among, parts_of
from humanoid_bt.record.rrd import RrdFile
from humanoid_bt.record.tick import Tick, percepts_of

AT = 1e-7
"""Engine times [s] that differ by less are the same: they are sums of floats."""

_ENTITY, _TIMELINE = "/flight", "sim_time"
_SHAPES = {"layout": shape.LAYOUT, "setup": shape.SETUP}  # of what is said once
_BLOCKS = ("plans", "cycles", "ticks", "news")
_BUNDLED = ("ticks", "news")
_LATE = 2.0  # s by which news may come later than it happened
_OLDER = "another program made it, or an older version"
_SHORT = "it was cut short before its first data, or another program made it, or an older version"


class News(NamedTuple):
    """Something that happened.

    Attributes:
        time: engine time [s].
        kind: node, results, event, key, unseen, stop, tree, end.
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
        setup: what was run, see :func:`~humanoid_bt.session.setup.run_setup`; what is not as it should be, whoever
            wrote it, is as if nobody knew.
        layout: what the rows of plans and cycles hold, empty if the file does not say.
        blocks: name -> blocks as they are in the file, packed.
        until: name -> the engine time [s] that no row of the block at the same place is beyond.
        missing: numbers of the parts that are not there, though a later one is.
        damaged: how many blocks could not be read so far.
        cut: why the file could not be read to its end, "" if it could.
    """

    path: Path
    setup: dict[str, Any] = field(default_factory=lambda: dict(shape.SETUP({})))
    layout: dict[str, Any] = field(default_factory=dict)
    blocks: dict[str, list[bytes]] = field(default_factory=lambda: {name: [] for name in _BLOCKS})
    until: dict[str, list[float]] = field(default_factory=lambda: {name: [] for name in _BLOCKS})
    missing: Sequence[int] = ()
    damaged: int = 0
    cut: str = ""

    def cycles(
        self,
        kind: str = "cycles",
        begin: float = -math.inf,
        end: float = math.inf,
        columns: Sequence[str] | None = None,
        labels: Sequence[str] | None = None,
    ) -> Cycles:
        """Return servo cycles, or with ``kind="plans"`` plans of the whole body.

        Args:
            kind: which of both.
            begin, end: engine times [s], both included; nothing else is unpacked.
            columns: names of those that are wanted, all if None.
            labels: of the numbers of these columns that are wanted, all if None.

        Raises:
            UserError: the recording does not say what is in them.
        """
        row = self.row(kind)
        kept = row.only(columns, labels)
        only = None if kept is row else [0, *row.places(kept)]  # the first number is the cycle's
        parts, damaged = [np.zeros((0, row.width if only is None else len(only)))], 0
        for block in self._blocks(kind, begin):
            try:
                part = unpack(block, row.resolution, only)
            except (BlockError, zlib.error):
                damaged += 1
                continue
            if len(part) and part[0, 0] * SERVO_PERIOD > end + AT:
                break
            parts.append(part)
        rows = np.concatenate(parts)
        time = rows[:, 0] * SERVO_PERIOD
        inside = (time >= begin - AT) & (time <= end + AT)
        rows, time = (rows, time) if inside.all() else (rows[inside], time[inside])
        split = kept.split(rows if only is None else rows[:, 1:])
        return Cycles(time, split, {column.name: column for column in kept.columns}, damaged)

    def row(self, kind: str) -> Row:
        """Return what a row of cycles or plans holds.

        Raises:
            UserError: the recording does not say.
        """
        try:
            return Row(*(Column(**{**column, "labels": tuple(column["labels"])}) for column in self.layout[kind]))
        except (KeyError, TypeError, AttributeError, ValueError):
            shown = relative(self.path)
            raise UserError(f"the recording {shown!r} has no servo cycles", hint=_OLDER) from None

    def ticks(self, begin: float = -math.inf, end: float = math.inf) -> Iterator[Tick]:
        """Yield ticks, in the order of time.

        Args:
            begin, end: engine times [s], both included.
        """
        for message in self._messages("ticks", begin):
            try:
                tick = Tick.decode(message)
            except WireError:
                self.damaged += 1
                continue
            if tick.state.time > end + AT:
                return
            if tick.state.time >= begin - AT:
                yield tick

    def seen_before(self, time: float) -> Iterator[Percept]:
        """Yield percepts that came up to an engine time [s], the latest first."""
        blocks, until = self.blocks["ticks"], self.until["ticks"]
        first = bisect_left(until, time - AT) + 1  # a tick may stand in the block after the cycles of its time
        for number in range(min(first, len(blocks) - 1), -1, -1):
            try:
                messages = unbundle(blocks[number])
                percepts = [percept for message in messages for percept in percepts_of(message)]
            except (BlockError, WireError, zlib.error):
                self.damaged += 1
                continue
            yield from (percept for percept in reversed(percepts) if percept.stamp <= time + AT)

    @cached_property
    def news(self) -> list[News]:
        """Everything that happened, in the order in which it was told."""
        return list(self.news_of())

    def news_of(self, *kinds: str, begin: float = -math.inf, end: float = math.inf) -> Iterator[News]:
        """Yield what happened of some kinds, of all if none is named; nothing else is decoded.

        Args:
            kinds: of news.
            begin, end: engine times [s], both included.
        """
        heads = tuple(json.dumps(kind).encode() for kind in kinds)
        last = bisect_left(self.until["news"], end + _LATE)
        for message in self._messages("news", begin, last + 1):
            if heads and not message.partition(b", ")[2].startswith(heads):
                continue
            try:
                time, kind, value = json.loads(message)
                found = News(shape.time(time), kind, shape.NEWS.get(kind, shape.anything)(value))
            except (ValueError, TypeError, RecursionError):
                self.damaged += 1
                continue
            if begin - AT <= found.time <= end + AT:
                yield found

    @property
    def damage(self) -> list[str]:
        """What of it was changed since it was written, a text each."""
        found = [f"part {number} is missing among its files" for number in self.missing]
        for name, blocks in self.blocks.items():
            if count := sum(not is_whole(block, name in _BUNDLED) for block in blocks):
                found.append(f"{count} of {len(blocks)} blocks of {name} are damaged")
        return [*found, f"{self.damaged} entries cannot be read"] if self.damaged else found

    @property
    def span(self) -> tuple[float, float]:
        """The engine times [s] of the first and the last servo cycle that the file has; both 0 if it has none."""
        first, last = self._edge(forward=True), self._edge(forward=False)
        return (float(first[0]), float(last[-1])) if len(first) and len(last) else (0.0, 0.0)

    def _edge(self, *, forward: bool) -> Array:
        """Return times [s] of the servo cycles in the outermost intact block on one side, empty if none is intact."""
        looks = list(pairwise([0.0, *self.until["cycles"][:-1], math.inf]))
        found = (self.cycles("cycles", *look, ("servo",)).time for look in (looks if forward else reversed(looks)))
        return next((times for times in found if len(times)), np.zeros(0))

    def _blocks(self, name: str, begin: float, last: int | None = None) -> list[bytes]:
        """Return the blocks, up to a number, in which something may be from a time [s] on."""
        return self.blocks[name][bisect_left(self.until[name], begin - AT) : last]

    def _messages(self, name: str, begin: float = -math.inf, last: int | None = None) -> Iterator[bytes]:
        for block in self._blocks(name, begin, last):
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
        files = files_of(log.path)
        log.missing = missing_among(files)
        for part in files:
            file = RrdFile(part)
            _fill(log, file)
            log.cut, log.damaged = log.cut or file.cut, log.damaged + file.damaged
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise UserError(f"{relative(log.path)!r} is no recording that can be read: {why}") from error
    if not log.layout:
        raise UserError(f"the recording {relative(log.path)!r} is none of a run", hint=_SHORT)
    return log


def read_cycles(path: str | PathLike[str], kind: str = "cycles") -> Cycles:
    """Return every servo cycle of a recording, or with ``kind="plans"`` every plan of the whole body.

    Args:
        path: the recording, or any of its parts: all of them are read, in order.
        kind: what is returned.

    Raises:
        UserError: the file is no recording, or has none of them.
    """
    return read_flight(path).cycles(kind)


def files_of(path: Path) -> list[Path]:
    """Return the files of all parts of a recording that hold anything; just this file where there are none.

    Args:
        path: of any part of it, or a link to one.
    """
    return [part for part in parts_of(_linked(path)) if is_recording(part)] or [path]


def _linked(path: Path) -> Path:
    """Return the file that a path leads to."""
    try:
        return path.resolve()
    except (OSError, RuntimeError):  # links in a circle
        return path


def _fill(log: FlightLog, file: RrdFile) -> None:
    """Take what a file holds into a log."""
    for batch in file.batches(_ENTITY):
        for column, time, value in _values(batch):
            if value is None:
                log.damaged += 1
            elif column not in _SHAPES:
                log.blocks[column].append(value)
                log.until[column].append(max(time, log.until[column][-1]) if log.until[column] else time)
            elif data := _data(value):
                setattr(log, column, _SHAPES[column](data))
            else:
                log.damaged += 1


def _data(text: str) -> dict[str, Any]:
    """Return the mapping that a text holds, an empty one if it holds none."""
    try:
        data = json.loads(text)
    except (ValueError, RecursionError):
        return {}
    return data if isinstance(data, dict) else {}


def _values(batch: Any) -> Iterator[tuple[str, float, Any]]:
    """Yield column, time [s] and value of all that is kept exactly; None where a row has none that could be it."""
    names = batch.schema.names
    timed = _TIMELINE in names
    times = [time.value for time in batch.column(_TIMELINE)] if timed else [0] * batch.num_rows  # a cast costs more
    for column in (*_SHAPES, *_BLOCKS):
        if column in names:
            wanted = str if column in _SHAPES else bytes
            for time, row in zip(times, batch.column(column).to_pylist(), strict=True):
                if row is not None:  # nothing was written into this column then
                    for value in row or [None]:
                        yield column, (time or 0) * 1e-9, value if isinstance(value, wanted) else None
