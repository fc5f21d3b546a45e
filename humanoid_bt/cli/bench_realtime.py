"""``humanoid-bt bench --realtime``: how punctual the servo is, and how quickly the robot stops."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable
from contextlib import closing
from dataclasses import asdict

from rich import box
from rich.table import Table
from rich.text import Text

from humanoid_bt.bench.baseline import SAME_LOOP
from humanoid_bt.bench.promises import LATENESS, RECORDED_TICK
from humanoid_bt.bench.punctuality import Punctuality
from humanoid_bt.bench.reactions import Reaction
from humanoid_bt.bench.realtime import OURS, Note, measure_realtime
from humanoid_bt.bench.ticks import RecordedTicks
from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.figures import judged, write_figures
from humanoid_bt.realtime.schedule import FIFO_HINT
from humanoid_bt.session.report import ExitCode

_LEAST = 1.0  # us; less matters to no loop of a millisecond, so a ratio of less says nothing


def bench_realtime(arguments: argparse.Namespace) -> int:
    """Measure, print two tables, write the JSON file if one is asked for."""
    console = SafeConsole()
    loops: list[Punctuality] = []
    answers: list[Reaction] = []
    ticks: list[RecordedTicks] = []
    notes: list[str] = []
    with (
        console.status("starting") as status,
        closing(measure_realtime(arguments.duration, arguments.repetitions, status.update)) as figures,
    ):
        for figure in figures:
            match figure:
                case Punctuality():
                    loops.append(figure)
                case Reaction():
                    answers.append(figure)
                case RecordedTicks():
                    ticks.append(figure)
                case Note():
                    notes.append(figure.text)
    notes += _notes(loops)
    console.print(_punctuality_table(loops, arguments.duration))
    console.print()
    console.print(_reaction_table(answers))
    console.print()
    console.print(_tick_table(ticks))
    for note in notes:
        console.print(f"note: {note}")
    if arguments.json:
        write_figures(
            arguments.json,
            {
                "repetitions": arguments.repetitions,
                "duration": arguments.duration,
                "cores": os.cpu_count(),
                "loops": [{**asdict(loop), "verdict": loop.verdict if loop.loop == OURS else None} for loop in loops],
                "reactions": [
                    {
                        **asdict(answer),
                        "p50": answer.p50,
                        "p99": answer.p99,
                        "max": answer.largest,
                        "verdict": answer.verdict,
                    }
                    for answer in answers
                ],
                "ticks": [{**asdict(pair), "added": pair.added, "verdict": pair.verdict} for pair in ticks],
                "notes": notes,
            },
        )
    return ExitCode.SUCCESS


def _punctuality_table(loops: list[Punctuality], duration: float) -> Table:
    bound = f"promised with FIFO: p99 {LATENESS.text}"
    table = _table(f"lateness of wake-ups [us], {duration:g} s each; {bound}", "", "loop")
    for name in ("p50", "p99", "p99.9", "max", "jitter p99", "missed"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for loaded in (False, True):
        group = [loop for loop in loops if loop.loaded is loaded]
        for index, loop in enumerate(sorted(group, key=lambda loop: loop.loop != OURS)):
            values = (_us(value) for value in _values(loop))
            table.add_row(
                _load(loaded) if index == 0 else "",
                loop.loop,
                *values,
                f"{loop.missed}/{loop.cycles + loop.missed}",
                judged(loop.verdict) if loop.loop == OURS else "",
                style="bold" if loop.loop == OURS else "",
            )
        named = {loop.loop: loop for loop in group}
        if OURS in named and SAME_LOOP in named:
            pairs = zip(_values(named[OURS]), _values(named[SAME_LOOP]), strict=True)
            table.add_row("", "servo to C", *(_ratio(*pair) for pair in pairs), "", "", style="dim")
    return table


def _values(loop: Punctuality) -> tuple[float, ...]:
    return loop.late_p50, loop.late_p99, loop.late_p999, loop.late_max, loop.jitter_p99


def _us(value: float) -> str:
    return f"{value:.1f}" if value < 100 else f"{value:.0f}"


def _ratio(ours: float, theirs: float) -> str:
    """Return how many times as late, "-" if nobody was late to speak of."""
    if max(ours, theirs) < _LEAST:
        return "-"
    ratio = ours / max(theirs, _LEAST)
    return f"{ratio:.1f}x" if ratio < 100 else f"{ratio:.0f}x"


def _reaction_table(answers: list[Reaction]) -> Table:
    table = _table("from the cause to the answer [ms]", "", "cause")
    for name in ("p50", "p99", "max", "promised", "answers", "stands"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for index, answer in enumerate(answers):
        first = index == 0 or answers[index - 1].loaded is not answer.loaded
        table.add_row(
            _load(answer.loaded) if first else "",
            answer.cause,
            *(f"{value:.1f}" if answer.delays else "-" for value in (answer.p50, answer.p99, answer.largest)),
            answer.promise.text if answer.promise else "",
            f"{len(answer.delays)}/{answer.repetitions}",
            f"{answer.standing}/{answer.repetitions}",
            judged(answer.verdict),
        )
    return table


def _tick_table(ticks: list[RecordedTicks]) -> Table:
    table = _table(f"ticks of decision [ms]; promised: a recording adds {RECORDED_TICK.text} of CPU", "", "runs")
    for name in ("CPU p99", "p50", "p99", "max", "stops", "missing"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for pair in ticks:
        for name, runs in (("with a recording", pair.recorded), ("without", pair.plain)):
            table.add_row(
                _load(runs.loaded) if runs.recorded else "",
                name,
                *(f"{value:.2f}" for value in (runs.cpu, runs.p50, runs.p99, runs.largest)),
                f"{runs.stops}",
                f"{runs.missing:.1f} s" if runs.recorded else "",
                judged(pair.verdict) if runs.recorded else "",
                style="bold" if runs.recorded else "",
            )
    return table


def _table(title: str, *columns: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, show_edge=False, title=Text(title), padding=(0, 1, 0, 0))
    table.title_justify, table.title_style = "left", "dim"
    for name in columns:
        table.add_column(name)
    return table


def _load(loaded: bool) -> str:
    return "load" if loaded else "idle"


def _notes(loops: Iterable[Punctuality]) -> list[str]:
    if any(loop.loop == OURS and not loop.fifo for loop in loops):
        return [f"without realtime priority, which the bounds of lateness ask for; {FIFO_HINT}"]
    return []
