"""``humanoid-bt bench``: a table of ratios with verdicts."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from rich.table import Table
from rich.text import Text

from humanoid_bt.bench.body import bodies_of
from humanoid_bt.bench.figure import Figure
from humanoid_bt.bench.figures import measure
from humanoid_bt.bench.speed import measure_speed
from humanoid_bt.bench.tree import measure_tree
from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.figures import judged, write_figures
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.loader import DEFAULT_ROBOT
from humanoid_bt.session.report import ExitCode

_OF_ROBOT = ("robot", "walk", "workspace")
_OF_BODY = ("only", "trials", "seed", "workers", "record")


def bench(arguments: argparse.Namespace) -> int:
    """Measure, print a table, write the JSON file if one is asked for."""
    if arguments.body:
        from humanoid_bt.cli.bench_body import bench_body

        return bench_body(arguments)
    if given := [name for name in _OF_BODY if getattr(arguments, name)]:
        raise UserError(f"--{given[0]} goes with --body")
    if given := [name for name in _OF_ROBOT if getattr(arguments, name) and not arguments.speed]:
        raise UserError(f"--{given[0]} goes with --body or --speed")
    if arguments.realtime:
        from humanoid_bt.cli.bench_realtime import bench_realtime

        return bench_realtime(arguments)
    console = SafeConsole()
    figures: list[Figure] = []
    with console.status("measuring") as status:
        for figure in _measured(arguments):
            figures.append(figure)
            status.update(f"measured: {figure.name}")
    console.print(_table(figures, arguments.repetitions))
    if arguments.json:
        figures_data = [figure.to_dict() for figure in figures]
        write_figures(arguments.json, {"repetitions": arguments.repetitions, "figures": figures_data})
    return ExitCode.SUCCESS


def _measured(arguments: argparse.Namespace) -> Iterator[Figure]:
    if arguments.speed:
        robot = Workspace(arguments.workspace).find_robot(arguments.robot or DEFAULT_ROBOT).absolute()
        bodies = [arguments.walk] if arguments.walk else bodies_of(load_robot(robot)[0].config)
        return measure_speed(robot, bodies, arguments.repetitions)
    if arguments.tree is None:
        return measure(arguments.repetitions)
    workspace = Workspace.of_argument(arguments.tree, None)
    return measure_tree(workspace.find_tree(arguments.tree), workspace, arguments.repetitions)


def _table(figures: list[Figure], repetitions: int) -> Table:
    title = f"ratios to a baseline in the same run: median of {repetitions} pairs (smallest to largest)"
    table = Table(box=None, pad_edge=False, title=title, title_justify="left", title_style="dim", header_style="dim")
    table.add_column("what", overflow="fold")
    for name in ("measured", "promised"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for figure in figures:
        beside = f"{figure.ours:.3g} to {figure.theirs:.3g} {figure.unit} ({figure.low:.2f}-{figure.high:.2f})"
        table.add_row(
            Text.assemble(figure.name, (f"\nto {figure.baseline}: {beside}", "dim")),
            Text(_measured_value(figure), "bold"),
            figure.promise.text if figure.promise else "",
            judged(figure.verdict),
        )
    return table


def _measured_value(figure: Figure) -> str:
    """Return what a promise is about: the ratio, or what it took."""
    if figure.promise is None or figure.promise.unit == "x":
        return f"{figure.ratio:.2f}x"
    return f"{figure.ours:.3g} {figure.promise.unit}"
