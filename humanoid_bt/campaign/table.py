"""The results of a campaign as a table, in the order of its trials, as CSV and Parquet."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import pyarrow as pa

from humanoid_bt.campaign.plan import Plan, Setting
from humanoid_bt.campaign.result import Cost, Result
from humanoid_bt.campaign.trial import Trial

VALUE = "result"
"""What stands before the name of something that a skill reported, in a column."""

_UNITS = {"time": "s"}

_LARGEST = 2**63 - 1  # whole number of a column


@dataclass(frozen=True)
class Row:
    """A trial and what came of it."""

    trial: Trial
    result: Result


@dataclass(frozen=True)
class Table:
    """What came of the trials of a campaign that are done.

    Attributes:
        plan: of the campaign.
        rows: a trial each, in their order.
    """

    plan: Plan
    rows: tuple[Row, ...]

    @classmethod
    def of(cls, plan: Plan, results: Mapping[int, Result]) -> Table:
        """Return the table of results by number of their trials."""
        return cls(plan, tuple(Row(trial, results[trial.number]) for trial in plan.trials if trial.number in results))

    @cached_property
    def values(self) -> dict[str, str]:
        """The names of what skills reported in any trial, each with its unit."""
        units = {name: row.result.units.get(name, "") for row in self.rows for name in row.result.values}
        return dict(sorted(units.items()))

    @cached_property
    def columns(self) -> dict[str, str]:
        """The names of the columns in their order, each with the SI unit of its numbers."""
        given = {factor.name: factor.unit for factor in self.plan.factors}
        reported = {f"{VALUE}.{name}": unit for name, unit in self.values.items()}
        about = dict.fromkeys(("outcome", "reason", "node", "time", "fell", "bumped", "stops", "missed"), "")
        return {
            **dict.fromkeys(("trial", "id", *Setting._fields, "seed"), ""),
            **given,
            **about,
            **reported,
            "trace": "",
        } | _UNITS

    def cells(self, row: Row) -> dict[str, Any]:
        """Return the values of a row by column; None where there is none."""
        trial, result = row.trial, row.result
        reported = {f"{VALUE}.{name}": result.values.get(name) for name in self.values}
        return {
            **{"trial": trial.number, "id": trial.id, "tree": trial.tree, "robot": trial.robot, "scene": trial.scene},
            **{"seed": trial.seed, **trial.given},
            **{"outcome": result.outcome, "reason": result.reason, "node": result.node, "time": result.time},
            **{"fell": result.fell, "bumped": result.bumped, "stops": result.stops, "missed": result.missed},
            **{**reported, "trace": result.trace},
        }

    def csv(self) -> bytes:
        """Return it as CSV, with the names of the columns first."""
        return _csv(list(self.columns), ([self.cells(row)[name] for name in self.columns] for row in self.rows))

    def arrow(self) -> Any:
        """Return it as a ``pyarrow.Table``, with units in its schema."""
        cells = [self.cells(row) for row in self.rows]
        columns = [_array([row[name] for row in cells]) for name in self.columns]
        fields = [
            pa.field(name, column.type, metadata={"unit": unit})
            for (name, unit), column in zip(self.columns.items(), columns, strict=True)
        ]
        return pa.Table.from_arrays(columns, schema=pa.schema(fields))

    def parquet(self) -> bytes:
        """Return it as Parquet."""
        from pyarrow import parquet  # noqa: PLC0415 (it takes a while)

        file = io.BytesIO()
        parquet.write_table(self.arrow(), file, compression="zstd")
        return file.getvalue()


def costs_csv(plan: Plan, costs: Mapping[int, Cost]) -> bytes:
    """Return what trials took on the wall clock as CSV, in the order of the trials."""
    done = (trial for trial in plan.trials if trial.number in costs)
    rows = ((trial.number, trial.id, costs[trial.number]) for trial in done)
    head = ["trial", "id", "wall", "simulating", "worker", "attempts"]
    return _csv(head, ([n, name, c.wall, c.simulating, c.worker, c.attempts] for n, name, c in rows))


def _csv(head: Sequence[str], rows: Iterator[Sequence[Any]]) -> bytes:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    writer.writerows([_text(cell) for cell in row] for row in rows)
    return text.getvalue().encode("utf-8", errors="replace")


def _text(value: Any) -> str:
    if isinstance(value, (bool, list, dict)):
        return json.dumps(value)
    return "" if value is None else str(value)


def _array(values: Sequence[Any]) -> Any:
    """Return a column of the narrowest type that all its values have; whole numbers of more than 64 bits are text."""
    kinds = {str if type(value) is int and abs(value) > _LARGEST else type(value) for value in values}
    kinds -= {type(None)}
    if kinds <= {int}:
        return pa.array(values, pa.int64())
    if kinds <= {int, float}:
        return pa.array([None if value is None else float(value) for value in values], pa.float64())
    if kinds == {bool}:
        return pa.array(values, pa.bool_())
    return pa.array([None if value is None else _text(value) for value in values], pa.string())
