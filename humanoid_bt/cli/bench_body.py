"""``humanoid-bt bench --body``: what a robot's body withstands, row by row, beside what is promised."""

from __future__ import annotations

import argparse
import shlex
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

from rich.text import Text

from humanoid_bt.bench.body import Withstood, chosen, measure_body
from humanoid_bt.bench.body_rows import Row
from humanoid_bt.campaign.statistics import Interval
from humanoid_bt.cli.campaign_progress import duration
from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.figures import judged, write_figures
from humanoid_bt.cli.output import hanging, print_lines
from humanoid_bt.core.errors import relative
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.record.folder import make_room
from humanoid_bt.record.folder_limits import load_limits
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.session.loader import DEFAULT_ROBOT
from humanoid_bt.session.options import RUNS, default_recording, make_folder
from humanoid_bt.session.report import ExitCode

_SEEDS = 5  # that failed, at most, which are named


def bench_body(arguments: argparse.Namespace) -> int:
    """Try the rows, print each as it is done, then what failed and how it is seen again; return the exit code."""
    name = arguments.robot or DEFAULT_ROBOT
    file = Workspace(arguments.workspace).find_robot(name).absolute()
    config = load_robot_config(file)
    rows = chosen(arguments.only or [])
    left_out = [row for row in rows if row.hands and not config.hands]
    rows = [row for row in rows if row not in left_out]
    first, number = arguments.seed or 0, arguments.trials or 20
    console = SafeConsole()
    console.print(f"what {config.name} withstands, in {number} trials each, seeds {first} to {first + number - 1}")
    _say(console, Text(_header(), "dim"))
    told: dict[str, Withstood] = {}
    interrupted = False
    with console.status("loading the robot") as status:
        pace = _Pace(len(rows) * number)

        def progress(found: Withstood) -> None:
            told[found.row.name] = found
            status.update(pace.after(found, number))

        measured = measure_body(
            file,
            rows,
            range(first, first + number),
            workers=arguments.workers or 1,
            progress=progress,
            recordings=_recordings() if arguments.record else None,
        )
        printed: set[str] = set()
        try:
            with closing(measured):
                for found in measured:
                    _say(console, _line(found))
                    printed.add(found.row.name)
        except KeyboardInterrupt:
            interrupted = True
    for found in told.values():
        if found.row.name not in printed:
            console.print(_line(found))
    for row in left_out:
        console.print(f"{row.name:<17}  {config.name} has no hands", style="dim")
    _print_failures(list(told.values()), arguments)
    if arguments.json:
        write_figures(
            arguments.json,
            {
                "robot": config.name,
                "trials": number,
                "first_seed": first,
                "whole": not interrupted,
                "rows": [found.to_dict() for found in told.values()],
            },
        )
    if interrupted:
        return ExitCode.INTERRUPTED
    return ExitCode.SUCCESS if all(found.verdict == "ok" for found in told.values()) else ExitCode.FAILURE


def _say(console: SafeConsole, line: Text) -> None:
    """Print a line that is seen at once, also by who reads a file or a pipe."""
    console.print(line)
    console.file.flush()


class _Pace:
    """Says how far it is, and how long it will take.

    Args:
        total: number of trials.
    """

    def __init__(self, total: int) -> None:
        self._total, self._done, self._began = total, 0, time.monotonic()

    def after(self, found: Withstood, number: int) -> str:
        """Return what there is to say after one more trial."""
        self._done += 1
        left = (time.monotonic() - self._began) / self._done * (self._total - self._done)
        return f"{found.row.name}: {len(found.trials)}/{number}; {self._done}/{self._total}, {duration(left)} left"


def _header() -> str:
    return f"{'':<17}  {'goal':>5}  {'feet':>5}  {'95 %':>8}  promised"


def _line(found: Withstood) -> Text:
    good, feet = found.good, found.on_feet
    reached = f"{good.count}/{good.of}" if found.row.walks else ""
    line = Text(f"{found.row.name:<17}  {reached:>5}  {f'{feet.count}/{feet.of}':>5}  ")
    line.append(f"{_between(good.interval):>8}  {f'{found.row.promise.bound:g} %':>8}  ")
    return line.append(judged(found.verdict))


def _between(interval: Interval) -> str:
    return f"{100 * interval.low:.0f}-{100 * interval.high:.0f} %"


def _print_failures(found: Sequence[Withstood], arguments: argparse.Namespace) -> None:
    for one in found:
        if not one.failed:
            continue
        worst = one.failed[0]
        print_lines(["", *hanging("", f"{one.row.name}: {one.row.what}")])
        for text, fell in (("fell", True), ("not there", False)):
            seeds = [done.task.trial.seed for done in one.failed if done.result.fell is fell]
            more = f" and {len(seeds) - _SEEDS} more" if len(seeds) > _SEEDS else ""
            if seeds:
                print_lines(hanging("  ", f"{text}: seeds {', '.join(map(str, seeds[:_SEEDS]))}{more}"))
        print_lines(hanging("  ", f"seed {worst.task.trial.seed}, {worst.result.time:.1f} s: {worst.result.reason}"))
        print_lines(hanging("  ", _again(one.row, worst.task.trial.seed, arguments)))
        if worst.task.recording:
            print_lines(hanging("  ", f"humanoid-bt explain {shlex.quote(relative(Path(worst.task.recording)))}"))


def _again(row: Row, seed: int, arguments: argparse.Namespace) -> str:
    """Return the command that records a trial."""
    words = ["humanoid-bt", "bench", "--body", "--only", row.name, "--seed", str(seed), "--trials", "1", "--record"]
    words += ["--robot", arguments.robot] if arguments.robot else []
    return shlex.join(words + (["--workspace", str(arguments.workspace)] if arguments.workspace else []))


def _recordings() -> Callable[[Row, int], Path]:
    """Return what says where trials are recorded, with room made for them; raises UserError."""
    make_folder()
    make_room(RUNS, load_limits(RUNS))
    return lambda row, seed: default_recording(f"{row.name}-seed{seed}").absolute()
