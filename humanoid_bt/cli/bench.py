"""``humanoid-bt bench``: a table of ratios."""

from __future__ import annotations

import argparse
import json
import platform
from pathlib import Path

from rich.console import Console
from rich.table import Table

from humanoid_bt.bench import Figure, measure
from humanoid_bt.errors import UserError
from humanoid_bt.session.report import ExitCode, versions


def bench(arguments: argparse.Namespace) -> int:
    """Measure, print a table, write the JSON file if one is asked for."""
    console = Console(highlight=False)
    figures: list[Figure] = []
    with console.status("measuring") as status:
        for figure in measure(arguments.repetitions):
            figures.append(figure)
            status.update(f"measured: {figure.name}")
    console.print(_table(figures, arguments.repetitions))
    if arguments.json:
        _write(arguments.json, figures, arguments.repetitions)
    return ExitCode.SUCCESS


def _table(figures: list[Figure], repetitions: int) -> Table:
    table = Table(
        box=None,
        pad_edge=False,
        title=f"medians of {repetitions} pairs; ratio = ours / baseline, smallest to largest in brackets",
        title_justify="left",
        title_style="dim",
    )
    for heading in ("what", "baseline"):
        table.add_column(heading, overflow="fold", ratio=1)
    for heading in ("ours", "baseline", "ratio", "must", "aim"):
        table.add_column(heading, justify="right", overflow="fold")
    for figure in figures:
        table.add_row(
            figure.name,
            figure.baseline,
            f"{figure.ours:.3g} {figure.unit}",
            f"{figure.theirs:.3g} {figure.unit}",
            f"{figure.ratio:.2f} ({figure.low:.2f}-{figure.high:.2f})",
            figure.must_text,
            figure.aim_text,
        )
    return table


def _write(path: Path, figures: list[Figure], repetitions: int) -> None:
    data = {
        "repetitions": repetitions,
        "machine": {"system": platform.platform(), "python": platform.python_version()},
        "versions": versions(),
        "figures": [figure.to_dict() for figure in figures],
    }
    try:
        path.write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    except OSError as error:
        raise UserError(f"the figures cannot be written to {str(path)!r}: {error.strerror}") from error
