"""Tables of a recording as files that other programs read: Parquet, CSV."""

from __future__ import annotations

import contextlib
import json
import secrets
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import pyarrow as pa

from humanoid_bt.core.errors import UserError, nearest, relative
from humanoid_bt.core.plain import plain
from humanoid_bt.review.columns import TABLES
from humanoid_bt.review.recording import Between, Recording
from humanoid_bt.review.samples import RATE

Progress = Callable[[str, float], None]
"""Is told what is written, and up to which engine time [s]."""

_RUN = "run.json"  # what was run, beside the tables


class Writer(Protocol):
    """What takes a table in parts."""

    def write(self, table: Any) -> None:
        """Take one more part, a ``pyarrow.Table`` or a ``RecordBatch``."""

    def close(self) -> None:
        """End the file."""


@dataclass(frozen=True)
class Wanted:
    """What of a recording is exported.

    Attributes:
        tables: their names.
        between: first and last engine time [s], None for all.
        rate: samples a second of those that are sampled.
    """

    tables: tuple[str, ...] = tuple(TABLES)
    between: Between | None = None
    rate: float = RATE

    @classmethod
    def of(cls, tables: Sequence[str], between: Between | None, rate: float) -> Wanted:
        """Return what is wanted; all tables if none are named.

        Raises:
            UserError: there is no such table.
        """
        if unknown := [name for name in tables if name not in TABLES]:
            raise UserError(f"no table {unknown[0]!r}", hint=nearest(unknown[0], TABLES))
        return cls(tuple(dict.fromkeys(tables)) or tuple(TABLES), between, rate)


def export_tables(
    recording: Recording, kind: str, folder: Path, wanted: Wanted, *, force: bool = False, progress: Progress
) -> list[Path]:
    """Write tables as files of a folder, and ``run.json`` with what was run; return the files.

    Args:
        recording: of which.
        kind: parquet or csv.
        folder: made if it is not there.
        wanted: which tables.
        force: overwrite files that are there.
        progress: is told how far it is.

    Raises:
        UserError: a file is there already or cannot be written, or the recording lacks what is asked for.
    """
    files = {name: folder / f"{name}.{kind}" for name in wanted.tables}
    run = folder / _RUN
    refuse_existing([*files.values(), run], force)
    with told_failures(folder):
        folder.mkdir(parents=True, exist_ok=True)
        for name, file in files.items():
            schema = _flat(TABLES[name].schema) if kind == "csv" else TABLES[name].schema
            batches = recording.batches(name, between=wanted.between, rate=wanted.rate)
            progress(name, 0.0)
            with replaced(file) as draft, contextlib.closing(_writer(kind, draft, schema)) as writer:
                for batch in batches:
                    writer.write(pa.Table.from_batches([batch]).cast(schema))
                    if batch.num_rows and "time" in schema.names:
                        progress(name, batch.column("time")[-1].as_py())
        about = {"title": recording.title, "outcome": recording.outcome, "reason": recording.reason}
        damage = recording.damage
        with replaced(run) as draft:
            text = json.dumps(plain({**about, "damage": damage, "setup": recording.setup}), indent=2)
            draft.write_text(f"{text}\n", encoding="utf-8", errors="replace")
    return [*files.values(), run]


def refuse_existing(files: Sequence[Path], force: bool) -> None:
    """See that nothing is overwritten that nobody said may be.

    Raises:
        UserError: a file is there.
    """
    there = [file for file in files if file.is_symlink() or file.exists()]
    if there and not force:
        more = f" and {len(there) - 1} more" if len(there) > 1 else ""
        hint = "--force overwrites, --output writes to another place"
        raise UserError(f"{relative(there[0])!r}{more} would be overwritten", hint=hint)


@contextlib.contextmanager
def told_failures(path: Path) -> Iterator[None]:
    """Tell why something cannot be written at a path.

    Raises:
        UserError: it cannot.
    """
    try:
        yield
    except (OSError, pa.ArrowException) as error:
        why = getattr(error, "strerror", None) or str(error).split("\n", maxsplit=1)[0]
        raise UserError(f"the export to {relative(path)!r} cannot be written: {why}") from error


@contextlib.contextmanager
def replaced(file: Path) -> Iterator[Path]:
    """Give a draft that takes a file's place when it is whole, and that goes away if it does not become so."""
    draft = file.with_name(f".{file.name[:100]}.{secrets.token_hex(4)}")
    try:
        yield draft
        draft.replace(file)
    finally:
        with contextlib.suppress(OSError):
            draft.unlink()


def _writer(kind: str, file: Path, schema: Any) -> Writer:
    writer: Writer
    if kind == "csv":
        from pyarrow import csv  # noqa: PLC0415  # only what is asked for is imported

        writer = csv.CSVWriter(file, schema)
    else:
        from pyarrow import parquet  # noqa: PLC0415  # likewise

        writer = parquet.ParquetWriter(file, schema, compression="zstd")
    return writer


def _flat(schema: Any) -> Any:
    """Return a schema with names as plain text, which is all that CSV has."""
    names = [pa.field(f.name, pa.string()) if pa.types.is_dictionary(f.type) else f for f in schema]
    return pa.schema(names)
