"""``humanoid-bt robots table``: robots side by side, with pictures and what was measured, in a folder."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

from rich.status import Status

from humanoid_bt.bench.body import Withstood, bodies_of, chosen, measure_body
from humanoid_bt.bench.body_rows import Row
from humanoid_bt.bench.robot_table import Entry, Likeness, Speed, markdown
from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.files.whole import write_whole
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.plant.portrait import portrait
from humanoid_bt.session.report import ExitCode

ROWS = ("fetch", "goals", "straight", "push-standing-100", "push-walking-100")
"""Rows of ``bench --body`` that a table has if none are chosen."""

_TRIALS = 4
_OUT, _TABLE = Path("robots"), "robots.md"


def robots_table(names: Sequence[str], arguments: argparse.Namespace) -> int:
    """Measure robots one after the other, and write the table anew after each; return the exit code.

    Raises:
        UserError: a robot has mistakes, or there is no such robot or row, or the folder cannot be written to.
    """
    if not names:
        raise UserError("robots table takes some robots", hint="humanoid-bt robots table humanoid sim/mine")
    workspace = Workspace(arguments.workspace)
    files = [workspace.find_robot(name).absolute() for name in names]
    called = [load_robot(file)[0].config.name for file in files]
    if twice := next((name for name in called if called.count(name) > 1), None):
        raise UserError(
            f"two of the robots are called {twice!r}", hint="give one of them another name in its robot.yaml"
        )
    rows, first = chosen(arguments.only or ROWS), arguments.seed or 0
    seeds = range(first, first + (arguments.trials or _TRIALS))
    folder = arguments.out or _OUT
    _make(folder)
    options = [
        *(["--trials", str(arguments.trials)] if arguments.trials else []),
        *(["--seed", str(first)] if first else []),
        *(["--only", *arguments.only] if arguments.only else []),
    ]
    command = shlex.join(["humanoid-bt", "robots", "table", *called, *options])
    console, entries = SafeConsole(), list[Entry]()
    with console.status("loading the first robot") as status:
        try:
            for file in files:
                entries += _tried(console, status, file, rows, seeds=seeds, workers=arguments.workers or 1, out=folder)
                _write(folder / _TABLE, markdown(entries, rows, command, seeds).encode())
        except KeyboardInterrupt:
            known = len({entry.likeness.name for entry in entries})
            print(f"interrupted: {known} of {len(files)} robots are in the table", file=sys.stderr)
            return ExitCode.INTERRUPTED
    console.print(f"written: {relative(folder / _TABLE)}")
    return ExitCode.SUCCESS


def _tried(
    console: SafeConsole, status: Status, file: Path, rows: Sequence[Row], *, seeds: range, workers: int, out: Path
) -> list[Entry]:
    """Return the lines of a robot, one for each of its bodies, and write its picture."""
    robot, standing = load_robot(file)
    config = robot.config
    status.update(f"{config.name}: picture")
    picture, why = portrait(robot, standing)
    if picture:
        _write(out / f"{config.name}.png", picture)
    else:
        console.print(f"{config.name}: no picture: {why}", style="dim")
    likeness = Likeness.of(file, f"{config.name}.png" if picture else "")
    bodies = bodies_of(config)
    tried = [row for row in rows if config.hands or not row.hands]
    found: list[Withstood] = []

    def progress(one: Withstood) -> None:
        status.update(f"{config.name}, {one.body}: {one.row.name} {len(one.trials)}/{len(seeds)}")

    with closing(measure_body(file, tried, seeds, workers=workers, progress=progress, bodies=bodies)) as measured:
        for one in measured:
            found.append(one)
            console.print(f"{config.name}, {one.body}: {one.row.name} {one.good.count}/{one.good.of}")
            console.file.flush()
    entries: list[Entry] = []
    for body in bodies:
        status.update(f"{config.name}, {body}: speed")
        own = [one for one in found if one.body == body]
        entries.append(Entry(likeness, body, own, Speed.of(file, body)))
    return entries


def _make(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"the folder {str(folder)!r} cannot be made: {error.strerror}", hint="--out DIR") from error


def _write(file: Path, content: bytes) -> None:
    try:
        write_whole(file, content)
    except OSError as error:
        raise UserError(f"{str(file)!r} cannot be written: {error.strerror}", hint="--out DIR") from error
