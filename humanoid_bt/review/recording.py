"""A recording, opened: what was run, and everything it holds as tables for a notebook."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from itertools import islice
from os import PathLike
from typing import Any

import pyarrow as pa

from humanoid_bt.core.errors import UserError, nearest, relative
from humanoid_bt.record.reading import AT, FlightLog, read_flight
from humanoid_bt.record.tick import Tick
from humanoid_bt.review import samples, setup
from humanoid_bt.review import ticks as ticking
from humanoid_bt.review.columns import TABLES
from humanoid_bt.review.happened import Happened, Row

Between = tuple[float, float]
_BATCH = 2000  # rows
_NO_SENSE = (TypeError, ValueError, LookupError, ArithmeticError, pa.ArrowException)


class Recording:
    """A recording of a run: what was run, what came of it, and tables of everything that happened.

    Nothing is unpacked before it is asked for. Every table is a ``pyarrow.Table``, with units in its schema; where
    pandas is installed, ``.to_pandas()`` makes a data frame of one. Whatever became of the file, what is intact is
    there; :attr:`damage` tells what is not.

    Args:
        log: what the file holds.

    Attributes:
        path: the file.
        happened: what was told during the run, as rows; tables have the same.
    """

    def __init__(self, log: FlightLog) -> None:
        self._log = log
        self.happened = Happened(log)
        self.path = log.path

    # ---- what was run -----------------------------------------------------------------------------------------------

    @property
    def setup(self) -> dict[str, Any]:
        """What was run: tree, robot, scene, seed, mode, files with their text, versions, machine."""
        return self._log.setup

    @property
    def parameters(self) -> dict[str, Any]:
        """The values of the tree's parameters in SI units: ``hbt.run(..., parameters=recording.parameters)``."""
        return {name: found.value for name, found in setup.parameters(self.setup["tree"]).items()}

    @property
    def outcome(self) -> str:
        """How the run ended: success, failure, unfinished, stopped, error or interrupted; "" if nobody knows."""
        return str(self.happened.end.get("outcome", ""))

    @property
    def reason(self) -> str:
        """Why it ended, in words."""
        return str(self.happened.end.get("reason", ""))

    @property
    def duration(self) -> float:
        """Engine time of the last that was recorded [s]."""
        try:
            return max(self._log.span[1], self.happened.last)
        except _NO_SENSE:  # it has no servo cycles
            return self.happened.last

    @property
    def ended(self) -> float:
        """Engine time at which the tree ended [s]; the robot is brought to a stand after it."""
        told = self.happened.end.get("tree_ended")
        return self.duration if told is None else float(told)

    @property
    def damage(self) -> list[str]:
        """What of the file cannot be read, a text each."""
        cut = [f"the file was read up to {self.duration:.2f} s: {self._log.cut}"] if self._log.cut else []
        return [*self._log.damage, *cut]

    # ---- tables -----------------------------------------------------------------------------------------------------

    def joints(
        self, *, between: Between | None = None, rate: float = samples.RATE, columns: Sequence[str] | None = None
    ) -> Any:
        """Return the joints, a row for each joint and moment; 1000 Hz has every servo cycle."""
        return self.table("joints", between=between, rate=rate, columns=columns)

    def body(
        self, *, between: Between | None = None, rate: float = samples.RATE, columns: Sequence[str] | None = None
    ) -> Any:
        """Return base, feet, hands and balance, a row for each moment; 1000 Hz has every servo cycle."""
        return self.table("body", between=between, rate=rate, columns=columns)

    def ticks(self, *, between: Between | None = None) -> Any:
        """Return the ticks of the tree: how long each took, what ran, what control knew."""
        return self.table("ticks", between=between)

    def nodes(self, *, between: Between | None = None) -> Any:
        """Return every change of a node's status."""
        return self.table("nodes", between=between)

    def spans(self, *, between: Between | None = None) -> Any:
        """Return when nodes ran, from their first tick to their end; those that did so at some time between."""
        return self.table("spans", between=between)

    def percepts(self, *, between: Between | None = None) -> Any:
        """Return what was perceived, and how old it was when the tree had it."""
        return self.table("percepts", between=between)

    def contacts(self, *, between: Between | None = None) -> Any:
        """Return what the robot felt that touched its arms or torso, a row for each tick and group of links."""
        return self.table("contacts", between=between)

    def commands(self, *, between: Between | None = None) -> Any:
        """Return what each tick commanded, a row for each resource, with the node that asked for it."""
        return self.table("commands", between=between)

    def results(self, *, between: Between | None = None) -> Any:
        """Return what skills reported."""
        return self.table("results", between=between)

    def events(self, *, between: Between | None = None) -> Any:
        """Return what else happened."""
        return self.table("events", between=between)

    def blackboard(self, *, between: Between | None = None) -> Any:
        """Return every change of the blackboard."""
        return self.table("blackboard", between=between)

    def stops(self, *, between: Between | None = None) -> Any:
        """Return every stop that the supervisor ordered."""
        return self.table("stops", between=between)

    def inputs(self, *, between: Between | None = None) -> Any:
        """Return what came from outside and is not sensed, as pushes, resets, and what was set or forced."""
        return self.table("inputs", between=between)

    def limits(self) -> Any:
        """Return the limits of the robot's joints."""
        return self.table("limits")

    def table(
        self,
        name: str,
        *,
        between: Between | None = None,
        rate: float = samples.RATE,
        columns: Sequence[str] | None = None,
    ) -> Any:
        """Return a table by its name.

        Args:
            name: joints, body, ticks, nodes and so on.
            between: only from one engine time to another [s], both included.
            rate: of joints and body: samples a second, 200 if not given, at most 1000.
            columns: only these.

        Raises:
            UserError: there is no such table or column, the times or the rate are none, or the recording has no
                servo cycles.
        """
        batches = list(self.batches(name, between=between, rate=rate, columns=columns))
        return pa.Table.from_batches(batches, _chosen(name, columns))

    def batches(
        self,
        name: str,
        *,
        between: Between | None = None,
        rate: float = samples.RATE,
        columns: Sequence[str] | None = None,
    ) -> Iterator[Any]:
        """Yield a table in parts, each a ``pyarrow.RecordBatch``; arguments as of :meth:`table`.

        However long the run was, this takes little memory.

        Raises:
            UserError: as :meth:`table`.
        """
        schema, spec = _chosen(name, columns), TABLES[name]
        begin, end = _times(between)
        if spec.sampled:
            yield from self._sampled(name, begin, end, samples.step_of(rate), schema)
        else:
            yield from self._listed(name, begin, end, schema)

    def every_tick(self) -> Iterator[Tick]:
        """Yield every tick as it was: what it saw, what it commanded."""
        return self._log.ticks()

    def _sampled(self, name: str, begin: float, end: float, step: int, schema: Any) -> Iterator[Any]:
        make: Callable[..., Iterator[dict[str, Any]]] = {"joints": samples.joints, "body": samples.body}[name]
        try:
            for part in make(self._log, begin, end, step):
                yield pa.RecordBatch.from_arrays([_array(part[f.name], f.type) for f in schema], schema=schema)
        except UserError:
            raise
        except _NO_SENSE as error:
            why = str(error).split("\n", maxsplit=1)[0]
            raise UserError(f"{relative(self.path)!r} has servo cycles that make no sense: {why}") from error

    def _listed(self, name: str, begin: float, end: float, schema: Any) -> Iterator[Any]:
        rows = iter(self._rows(name, begin, end))
        timed = TABLES[name].columns[0].name == "time"
        while batch := list(islice(rows, _BATCH)):
            kept = [row for row in batch if not timed or _is_between(row, begin, end)]
            columns = [pa.array([_whole(row.get(f.name)) for row in kept], f.type) for f in schema]
            yield pa.RecordBatch.from_arrays(columns, schema=schema)

    def _rows(self, name: str, begin: float, end: float) -> Iterable[Row]:
        happened = self.happened
        ticks = partial(self._log.ticks, begin, end)
        makers: dict[str, Callable[[], Iterable[Row]]] = {
            "ticks": lambda: ticking.ticks(ticks(), happened.nodes),
            "percepts": lambda: ticking.percepts(ticks()),
            "contacts": lambda: ticking.contacts(ticks()),
            "commands": lambda: ticking.commands(ticks()),
            "spans": lambda: happened.spans(self.ended),
            "limits": lambda: setup.joints(self.setup),
            "parameters": self._parameters,
        }
        return makers[name]() if name in makers else getattr(happened, name)

    def _parameters(self) -> Iterator[Row]:
        for name, found in setup.parameters(self.setup["tree"]).items():
            written = None if found.written is None else str(found.written)
            yield {"name": name, "value": json.dumps(found.value), "written": written, "origin": found.origin}

    def __repr__(self) -> str:
        return "\n".join([f"{relative(self.path)}: {self.title}", *(f"  {text}" for text in self.damage)])

    @property
    def title(self) -> str:
        """What was run and how it ended, in a line."""
        named = [self.setup[key]["name"] or "?" for key in ("tree", "robot", "scene")]
        end, lasted = self.outcome or "no end", self.ended - self.happened.first
        return f"{named[0]} on {named[1]} in {named[2]}, seed {self.setup['seed']}: {end} after {lasted:.2f} s"


def open_recording(path: str | PathLike[str]) -> Recording:
    """Open the recording of a run.

    Args:
        path: the file, ``runs/fetch-20260101-120000.rrd``.

    Raises:
        UserError: there is none, or it is none that can be read.
    """
    if not isinstance(path, (str, os.PathLike)):
        raise UserError(f"a recording is opened by its file, not by {path!r}")
    return Recording(read_flight(path))


def _chosen(name: str, columns: Sequence[str] | None) -> Any:
    """Return the schema of a table with some of its columns, all if None.

    Raises:
        UserError: there is no such table or column.
    """
    if name not in TABLES:
        raise UserError(f"no table {name!r}", hint=nearest(str(name), TABLES))
    schema = TABLES[name].schema
    if columns is None:
        return schema
    if unknown := [column for column in columns if column not in schema.names]:
        raise UserError(f"the table {name!r} has no column {unknown[0]!r}", hint=nearest(str(unknown[0]), schema.names))
    return pa.schema([schema.field(column) for column in columns], metadata=schema.metadata)


def _times(between: Between | None) -> Between:
    """Return the first and the last engine time [s] that are wanted.

    Raises:
        UserError: they are none.
    """
    if between is None:
        return -math.inf, math.inf
    try:
        begin, end = map(float, between)
    except (TypeError, ValueError):
        begin, end = math.nan, math.nan
    if not begin <= end:
        raise UserError(
            f"'between' must be two engine times, the earlier one first, not {between!r}", hint="(3.0, 8.0)"
        )
    return begin, end


def _is_between(row: Row, begin: float, end: float) -> bool:
    first: float = row["time"]
    last: float = row.get("ended", first)
    return first <= end + AT and last >= begin - AT


def _whole(value: Any) -> Any:
    """Return a value without half characters, which no file takes."""
    return value.encode(errors="replace").decode() if isinstance(value, str) and not value.isascii() else value


def _array(values: Any, kind: Any) -> Any:
    """Return values as an array of their column's type."""
    return values.cast(kind) if isinstance(values, pa.Array) else pa.array(values, kind)
