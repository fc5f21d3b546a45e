"""Reading a recording back."""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import chain
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from humanoid_bt.control.cycle_log import Column, Row
from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.messages import Array
from humanoid_bt.record.packing import BlockError, unpack
from humanoid_bt.record.parts import is_recording, parts_of


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


def read_cycles(path: str | PathLike[str], kind: str = "cycles") -> Cycles:
    """Return every servo cycle of a recording, or with ``kind="plans"`` every plan of the whole body.

    Args:
        path: the recording, or any of its parts: all of them are read, in order.
        kind: what is returned.

    Raises:
        UserError: the file is no recording, or has none of them.
    """
    layout, blocks = None, []
    for entity, column, value in chain.from_iterable(_values(part, "layout", "block") for part in _parts(Path(path))):
        if entity == "/flight" and column == "layout":
            layout = json.loads(value)
        elif entity == f"/flight/{kind}" and column == "block":
            blocks.append(value)
    if layout is None:
        message = f"the recording {relative(Path(path))!r} has no servo cycles"
        raise UserError(message, hint="recordings have them since version 0.1")
    row = Row(*(Column(**{**column, "labels": tuple(column["labels"])}) for column in layout[kind]))
    tables, damaged = [np.zeros((0, row.width))], 0
    for block in blocks:
        try:
            tables.append(unpack(block, row.resolution))
        except BlockError:
            damaged += 1
    rows = np.concatenate(tables)
    described = {column.name: column for column in row.columns}
    return Cycles(rows[:, 0] * SERVO_PERIOD, row.split(rows), described, damaged)


def _parts(path: Path) -> list[Path]:
    """Return all parts of a recording that hold anything; just this file where there are none."""
    return [part for part in parts_of(path) if is_recording(part)] or [path]


def _values(path: Path, *columns: str) -> Iterator[tuple[str, str, Any]]:
    """Yield entity, column and value of these columns, in the order of the file."""
    import rerun as rr  # noqa: PLC0415  # it takes half a second, and most programs read nothing

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a recording that is still written, or was never closed
            reader = rr.chunk.RrdReader(path)
        for chunk in reader.stream():
            batch = chunk.to_record_batch()
            for column in set(columns) & set(batch.schema.names):
                for row in batch.column(column):
                    for value in row.as_py() or ():
                        yield chunk.entity_path, column, value
    except (RuntimeError, OSError, ValueError) as error:
        reason = str(error).strip().split("\n", maxsplit=1)[0]
        raise UserError(f"{relative(path)!r} is no recording that can be read: {reason}") from error
