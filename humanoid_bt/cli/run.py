"""``humanoid-bt run``: what happens, as it happens, and a summary."""

from __future__ import annotations

import argparse
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from py_trees.common import Status
from rich.console import Console
from rich.live import Live
from rich.text import Text

from humanoid_bt.errors import UserError
from humanoid_bt.record.sinks import Sinks, has_display
from humanoid_bt.session.report import Report
from humanoid_bt.session.run import Run, RunOptions, default_recording
from humanoid_bt.tree.executor import NodeChange
from humanoid_bt.tree.tree import Tree
from humanoid_bt.workspace import Workspace

_SIGNS = {
    Status.RUNNING: ("▶", "cyan"),
    Status.SUCCESS: ("✓", "green"),
    Status.FAILURE: ("✗", "yellow"),
    Status.INVALID: ("○", "dim"),
}
_LEVELS = {"info": ("•", "blue"), "warning": ("!", "yellow"), "error": ("■", "red")}
_OUTCOME_STYLES = {"success": "bold green", "failure": "bold yellow", "unfinished": "bold yellow"}


def run(arguments: argparse.Namespace) -> int:
    """Run a tree; return the exit code."""
    workspace = _workspace(arguments)
    options = _options(arguments)
    console = Console(highlight=False)
    printer = Printer(console, arguments.quiet)
    session = Run(options, workspace, printer)
    if arguments.report:
        _check_writable(arguments.report)
    printer.tree = session.tree
    if not arguments.quiet:
        console.print(
            f"[bold]{session.tree.name}[/] on {session.robot_name} in {session.scene_name}, seed {options.seed}"
        )
        if options.sinks.serve:
            console.print(f"live view: http://127.0.0.1:{options.sinks.serve}")
    with printer, _interruptions(printer) as interrupted:
        report = session.execute(interrupted)
    _summary(console, report)
    if arguments.report:
        report.write(arguments.report)
    return report.exit_code


def _workspace(arguments: argparse.Namespace) -> Workspace:
    if arguments.workspace:
        return Workspace(arguments.workspace)
    path = Path(arguments.tree)
    return Workspace.of_tree(path) if path.is_file() else Workspace()


def _options(arguments: argparse.Namespace) -> RunOptions:
    live = arguments.serve is not None or arguments.view
    view = arguments.view
    if view is None:
        view = arguments.serve is None and has_display()
        live = live or view
    file = None if arguments.no_record else arguments.record or default_recording(arguments.tree)
    return RunOptions(
        tree=arguments.tree,
        robot=arguments.robot,
        scene=arguments.scene,
        overrides=_overrides(arguments.overrides),
        seed=arguments.seed,
        duration=arguments.duration,
        pace=arguments.pace or (1.0 if live else None),
        sinks=Sinks(file=file, view=view, serve=arguments.serve),
    )


def _overrides(texts: list[str]) -> dict[str, str]:
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise UserError(f"--set {text!r} is not NAME=VALUE", hint="example: --set reach_distance=0.45")
        values[name.strip()] = value
    return values


def _check_writable(path: Path) -> None:
    """Find out before the run that its report cannot be written after it."""
    try:
        with path.open("a", encoding="utf-8"):
            pass
    except OSError as error:
        raise UserError(f"the report cannot be written to {str(path)!r}: {error.strerror}") from error


@contextmanager
def _interruptions(printer: Printer) -> Iterator[Callable[[], str]]:
    """Turn Ctrl-C and SIGTERM into a reason to end the run; a second Ctrl-C ends at once."""
    reasons: list[str] = []

    def note(number: int, _frame: FrameType | None) -> None:
        if reasons:
            raise KeyboardInterrupt
        reasons.append("Ctrl-C" if number == signal.SIGINT else "SIGTERM")
        printer.say("bringing the robot to a stand; once more to quit at once")

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: reasons[0] if reasons else ""
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


class Printer:
    """Prints what happens: a line per skill or condition that changed, a progress line on a terminal."""

    _REFRESH = 0.1  # s between progress lines

    def __init__(self, console: Console, quiet: bool) -> None:
        self._console, self._quiet = console, quiet
        self._live: Live | None = None
        self._began = self._last = time.monotonic()
        self._shown: dict[str, tuple[Status, str]] = {}
        self._kinds: dict[str, str] = {}
        self._names: dict[str, str] = {}

    @property
    def tree(self) -> Tree:
        """The tree whose nodes are printed."""
        raise AttributeError("write only")

    @tree.setter
    def tree(self, tree: Tree) -> None:
        self._kinds = {node.path: node.kind for node in tree.nodes}
        self._names = {node.path: node.name for node in tree.nodes}

    def __enter__(self) -> Printer:
        if self._console.is_terminal and not self._quiet:
            self._live = Live(console=self._console, transient=True, auto_refresh=False)
            self._live.start()
        return self

    def __exit__(self, *_: Any) -> None:
        if self._live is not None:
            self._live.stop()

    def node_changed(self, change: NodeChange) -> None:
        """Print what a skill or condition became, unless it says what it said last."""
        kind = self._kinds.get(change.path)
        told = self._shown.get(change.path)
        self._shown[change.path] = (change.status, change.feedback)
        if self._quiet or kind not in ("skill", "condition"):
            return
        if kind == "condition" and (change.status is Status.INVALID or (told and told[0] is change.status)):
            return
        sign, style = _SIGNS[change.status]
        said = change.feedback if change.status is not Status.INVALID else change.feedback or "halted"
        self._line(change.time, sign, style, self._names.get(change.path, change.path), said)

    def event(self, time: float, level: str, text: str) -> None:
        """Print an event."""
        if not self._quiet or level == "error":
            sign, style = _LEVELS[level]
            self._line(time, sign, style, "", text)

    def progress(self, time: float, running: str) -> None:
        """Show where the run is."""
        if self._live is None:
            return
        now = _wall()
        if now - self._last >= self._REFRESH:
            self._last = now
            speed = time / max(now - self._began, 1e-6)
            self._live.update(Text(f"{time:7.2f} s  {running}  ({speed:.1f}x real time)", style="dim"), refresh=True)

    def say(self, text: str) -> None:
        """Print a line of our own."""
        self._console.print(text)

    def _line(self, at: float, sign: str, style: str, name: str, text: str) -> None:
        line = Text.assemble(
            (f"{at:7.2f} s ", "dim"), (f"{sign} ", style), (f"{name:<12} " if name else "", "bold"), text
        )
        self._console.print(line, soft_wrap=not self._console.is_terminal)


def _wall() -> float:
    return time.monotonic()


def _summary(console: Console, report: Report) -> None:
    style = _OUTCOME_STYLES.get(report.outcome, "bold red")
    console.print(Text.assemble("\n", (report.outcome, style), f": {report.reason}"))
    rows = [
        ("simulated", f"{report.sim_time:.2f} s in {report.wall_time:.2f} s ({report.real_time_factor:.1f}x real time)")
    ]
    if report.hand_error is not None:
        rows.append(("hand error", f"{report.hand_error * 100:.1f} cm"))
    stops = ", ".join(f"{s['mode'].replace('_', ' ')} at {s['time']:.2f} s ({s['reason']})" for s in report.stops)
    rows.append(("stops", stops or "none"))
    rows.append(("trace", report.trace_hash[:16]))
    if report.recording:
        rows.append(("recording", report.recording))
        rows.append(("open it", f"{_viewer_command()} {report.recording}"))
    for name, value in rows:
        console.print(f"  {name:<11}{value}", soft_wrap=True)


def _viewer_command() -> str:
    """Return the viewer's command: beside this interpreter if it is not on the path."""
    beside = Path(sys.executable).parent / "rerun"
    import shutil

    if shutil.which("rerun") or not beside.exists():
        return "rerun"
    try:
        return str(beside.relative_to(Path.cwd()))
    except ValueError:
        return str(beside)
