"""``humanoid-bt export``: a recording for other programs."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.review.export import Progress as Tell
from humanoid_bt.review.export import Wanted, export_tables
from humanoid_bt.review.newest import newest_recording
from humanoid_bt.review.recording import Recording, open_recording
from humanoid_bt.session.report import ExitCode


def export(arguments: argparse.Namespace) -> int:
    """Write a recording's data; tell what was written, and what of the recording is damaged."""
    tables = [name.strip() for name in arguments.tables.split(",") if name.strip()]
    between = None if arguments.between is None else (arguments.between[0], arguments.between[1])
    wanted = Wanted.of(tables, between, arguments.rate)
    if tables and arguments.to == "mcap":
        raise UserError("--tables goes with parquet and csv; an MCAP file has topics", hint="leave it out")
    recording = open_recording(arguments.recording or newest_recording())
    with _progress(recording, wanted) as progress:
        files = _write(arguments, recording, wanted, progress)
    for text in recording.damage:
        print(f"warning: {text}", file=sys.stderr)
    size = sum(file.stat().st_size for file in files)
    where = files[0] if len(files) == 1 else files[0].parent
    print(f"{relative(where)}: {size / 1e6:.1f} MB of {recording.title}")
    return ExitCode.SUCCESS


def _write(arguments: argparse.Namespace, recording: Recording, wanted: Wanted, progress: Tell) -> list[Path]:
    if arguments.to == "mcap":
        from humanoid_bt.review.mcap_file import export_mcap

        file = arguments.output or recording.path.with_suffix(".mcap")
        return export_mcap(recording, file, wanted, force=arguments.force, progress=progress)
    beside = recording.path.with_suffix("")
    folder = arguments.output or (beside if beside != recording.path else beside.with_name(f"{beside.name}-tables"))
    return export_tables(recording, arguments.to, folder, wanted, force=arguments.force, progress=progress)


@contextmanager
def _progress(recording: Recording, wanted: Wanted) -> Iterator[Tell]:
    """Show how far an export is, at a terminal."""
    console = SafeConsole(stderr=True)
    if not console.is_terminal:
        yield lambda what, time: None
        return
    begin, end = wanted.between or (0.0, recording.duration)
    columns = (TextColumn("{task.description:<10}"), BarColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console, transient=True) as bars:
        task = bars.add_task("", total=max(end - begin, 1e-3))
        yield lambda what, time: bars.update(task, description=what, completed=max(time - begin, 0.0))
