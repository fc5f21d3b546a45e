"""``humanoid-bt bench --body``: what a robot's body withstands, row by row, beside what is promised."""

from __future__ import annotations

import argparse
import shlex
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing
from pathlib import Path
from statistics import fmean

from rich.text import Text

from humanoid_bt.bench.body import Withstood, bodies_of, chosen, measure_body
from humanoid_bt.bench.body_rows import Row
from humanoid_bt.bench.gait import GaitFigure
from humanoid_bt.campaign.statistics import Interval
from humanoid_bt.cli.campaign_progress import duration
from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.figures import judged, write_figures
from humanoid_bt.cli.output import hanging, print_lines
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import relative
from humanoid_bt.core.units import readable
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.record.folder import make_room
from humanoid_bt.record.folder_limits import load_limits
from humanoid_bt.robot.config import RobotConfig, Walk
from humanoid_bt.session.loader import DEFAULT_ROBOT
from humanoid_bt.session.options import RUNS, default_recording, make_folder
from humanoid_bt.session.report import ExitCode

_TRIALS = 20
_SEEDS = 5  # that failed, at most, which are named
_HEADER = f"{'':<17}  {'goal':>5}  {'feet':>5}  {'95 %':>8}  promised"
_BESIDE = 22  # columns of each of several bodies
_GAIT_HEADER = f"{'gait':<17}{'mean':>8}{'median':>8}{'worst':>8}  {'promised':>10}"


def bench_body(arguments: argparse.Namespace) -> int:
    """Try a robot, print each row as it is done, then what failed and how it is seen again; return the exit code."""
    file = Workspace(arguments.workspace).find_robot(arguments.robot or DEFAULT_ROBOT).absolute()
    config = load_robot(file, arguments.walk)[0].config
    bodies = _bodies(config, arguments.walk)
    asked = chosen(arguments.only or [])
    rows = [row for row in asked if config.hands or not row.hands]
    first, number = arguments.seed or 0, arguments.trials or _TRIALS
    console = SafeConsole()
    seeds = range(first, first + number)
    trials = f"{number} trials each, seeds {first} to {seeds[-1]}" if number > 1 else f"a trial each, seed {first}"
    console.print(f"what {config.name} withstands, in {trials}")
    for line in _headers(bodies):
        _say(console, Text(line, "dim"))
    found, whole = _tried(console, arguments, file, rows, seeds=seeds, bodies=bodies)
    for row in asked:
        if row not in rows:
            console.print(f"{row.name:<17}  {config.name} has no hands", style="dim")
    figures: list[GaitFigure] = []
    for body in bodies:
        figures += _gait(console, [one for one in found if one.body == body], body)
    for one in found:
        for told in _limits(one):
            _say(console, told)
    for one in found:
        if one.failed:
            print_lines(["", *_failures(one, arguments)])
    if arguments.record:
        print_lines(["", *_recorded(found)])
    if arguments.json:
        head = {"robot": config.name, "trials": number, "first_seed": first, "whole": whole}
        write_figures(arguments.json, {**head, "rows": [one.to_dict() for one in found]})
    if not whole:
        done = sum(len(one.trials) for one in found)
        print(f"interrupted after {done} of {len(rows) * len(bodies) * number} trials", file=sys.stderr)
        return ExitCode.INTERRUPTED
    kept = {one.verdict for one in found} | {figure.verdict for figure in figures} <= {"ok"}
    return ExitCode.SUCCESS if kept else ExitCode.FAILURE


def _bodies(config: RobotConfig, walk: Walk | None) -> list[Walk | None]:
    """Return what is tried: all bodies of a robot that has several, the one that its file names first."""
    bodies: list[Walk | None] = [*bodies_of(config)]
    return [walk] if walk is not None or len(bodies) == 1 else bodies


def _gait(console: SafeConsole, found: Sequence[Withstood], body: Walk | None) -> list[GaitFigure]:
    """Print what some rows tell of the gait of a body, and return it."""
    figures = [figure for one in found for figure in one.gait]
    if figures:
        _say(console, Text(f"\n{_GAIT_HEADER}{f'  {body}' if body else ''}", "dim"))
    for figure in figures:
        _say(console, _gait_line(figure))
    return figures


def _tried(
    console: SafeConsole,
    arguments: argparse.Namespace,
    robot: Path,
    rows: Sequence[Row],
    *,
    seeds: Sequence[int],
    bodies: Sequence[Walk | None],
) -> tuple[list[Withstood], bool]:
    """Try rows and print each as it is done; return what is known of those that are begun, and whether that is all."""
    known: dict[tuple[str, Walk | None], Withstood] = {}
    left = [row.name for row in rows]
    began, total = time.monotonic(), len(rows) * len(bodies) * len(seeds)

    def of(name: str) -> list[Withstood]:
        return [known[name, body] for body in bodies if (name, body) in known]

    def progress(found: Withstood) -> None:
        known[found.row.name, found.body] = found
        done = sum(len(one.trials) for one in known.values())
        to_go = duration((time.monotonic() - began) / done * (total - done))
        status.update(f"{found.row.name}: {len(found.trials)}/{len(seeds)}; {done}/{total}, {to_go} left")

    recordings = _recordings() if arguments.record else None
    workers = arguments.workers or 1
    with console.status("loading the robot") as status:
        try:
            with closing(
                measure_body(
                    robot, rows, seeds, workers=workers, progress=progress, recordings=recordings, bodies=bodies
                )
            ) as measured:
                for found in measured:
                    if found.body == bodies[-1]:
                        left.remove(found.row.name)
                        _say(console, _line(of(found.row.name), len(bodies)))
        except KeyboardInterrupt:
            pass
    for name in left:
        if of(name):
            _say(console, _line(of(name), len(bodies)))
    return [found for row in rows for found in of(row.name)], not left


def _say(console: SafeConsole, line: Text) -> None:
    """Print a line that is seen at once, also by who reads a file or a pipe."""
    console.print(line, soft_wrap=True)
    console.file.flush()


def _headers(bodies: Sequence[Walk | None]) -> list[str]:
    if len(bodies) == 1:
        return [_HEADER]
    over = "".join(f"{body:^{_BESIDE}}" for body in bodies)
    each = f"  {'goal':>5}  {'feet':>5}".ljust(_BESIDE)
    return [f"{'':<17}{over}", f"{'':<17}{each * len(bodies)}  promised"]


def _line(found: Sequence[Withstood], bodies: int) -> Text:
    """Return the line of a row, as many bodies side by side; the last ones may not be known yet."""
    row = found[0].row
    line = Text(f"{row.name:<17}")
    for one in found:
        reached = f"{one.good.count}/{one.good.of}" if row.walks else ""
        line.append(f"  {reached:>5}  {f'{one.on_feet.count}/{one.on_feet.of}':>5}")
        if bodies > 1:
            line.append("  ").append(judged(one.verdict)).append(" " * (6 - len(one.verdict)))
    line.append(" " * _BESIDE * (bodies - len(found)))
    if bodies == 1:
        line.append(f"  {_between(found[0].good.interval):>8}")
    line.append(f"  {f'{row.promise.bound:g} %':>8}")
    return line if bodies > 1 else line.append("  ").append(judged(found[0].verdict))


def _gait_line(figure: GaitFigure) -> Text:
    promise = figure.promise
    values = "".join(f"{value:8.2f}" for value in (figure.value, figure.median, figure.most))
    return Text(f"{figure.name:<17}{values}  {promise.text:>10}  ").append(judged(figure.verdict))


def _limits(found: Withstood) -> Iterator[Text]:
    """Yield what the trials of a row that reached the goal have shown of what it limits, beside the limit."""
    limits = found.row.limits
    seen = [
        done.result for done in found.trials if done.result.succeeded and limits.keys() <= done.result.values.keys()
    ]
    if not (seen and limits):
        return
    of = f"  {found.body}" if found.body else ""
    yield Text(f"\n{found.row.name:<17}{'mean':>12}{'worst':>12}{'limit':>12}{of}", "dim")
    for name, limit in limits.items():
        values, unit = [float(result.values[name]) for result in seen], seen[0].units.get(name, "")
        told = (_figure(value, unit) for value in (fmean(values), max(values), limit))
        yield Text(f"{name.replace('_', ' '):<17}" + "".join(f"{one:>12}" for one in told))


def _figure(value: float, unit: str) -> str:
    return readable(value, unit, 1) if unit else f"{100 * value:.2f} %"


def _between(interval: Interval) -> str:
    return f"{100 * interval.low:.0f}-{100 * interval.high:.0f} %"


def _failures(found: Withstood, arguments: argparse.Namespace) -> Iterator[str]:
    """Yield which trials of a row failed, why the worst did, and the command that records it."""
    yield from hanging("", f"{found.row.name}{f' ({found.body})' if found.body else ''}: {found.row.what}")
    for text, fell in (("fell", True), ("not there", False)):
        seeds = [str(done.task.trial.seed) for done in found.failed if done.result.fell is fell]
        more = f" and {len(seeds) - _SEEDS} more" if len(seeds) > _SEEDS else ""
        if seeds:
            yield from hanging("  ", f"{text}: seeds {', '.join(seeds[:_SEEDS])}{more}")
    worst = found.failed[0]
    seed, result = worst.task.trial.seed, worst.result
    yield from hanging("  ", f"seed {seed}, {result.time:.1f} s: {result.reason}")
    if worst.task.recording:
        yield f"  humanoid-bt explain {shlex.quote(relative(Path(worst.task.recording)))}"
        return
    words = ["humanoid-bt", "bench", "--body", "--only", found.row.name, "--seed", str(seed), "--trials", "1"]
    words += ["--record", *(["--robot", arguments.robot] if arguments.robot else [])]
    words += ["--walk", found.body] if found.body else []
    words += ["--workspace", str(arguments.workspace)] if arguments.workspace else []
    yield f"  {shlex.join(words)}"


def _recorded(found: Sequence[Withstood]) -> Iterator[str]:
    """Yield how recordings are opened."""
    files = [done.task.recording for one in found for done in one.trials]
    yield from (f"open it: rerun {shlex.quote(relative(Path(file)))}" for file in files[:_SEEDS])
    if len(files) > _SEEDS:
        yield f"and {len(files) - _SEEDS} more in {RUNS}"


def _recordings() -> Callable[[Row, int, Walk | None], Path]:
    """Return what says where trials are recorded, with room made for them; raises UserError."""
    make_folder()
    make_room(RUNS, load_limits(RUNS))
    return lambda row, seed, body: default_recording(f"{row.name}{f'-{body}' if body else ''}-seed{seed}").absolute()
