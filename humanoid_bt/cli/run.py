"""``humanoid-bt run``: from the arguments to the exit code."""

from __future__ import annotations

import argparse
import math
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from rich.console import Console
from rich.text import Text

from humanoid_bt.checking.check import settled
from humanoid_bt.cli import keys
from humanoid_bt.cli.findings import print_findings
from humanoid_bt.cli.printer import Printer, print_summary
from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.record.sinks import Sinks, has_display
from humanoid_bt.session.options import DURATION, RunOptions, default_recording
from humanoid_bt.session.run import Run
from humanoid_bt.tree.tree import Tree

_KEYBOARD = "keyboard"
_SIGNALS = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM", signal.SIGHUP: "the terminal was closed"}


def run(arguments: argparse.Namespace) -> int:
    """Run a tree; return the exit code."""
    options = _options(arguments)
    console = Console(highlight=False)
    printer = Printer(console, arguments.quiet)
    workspace = Workspace.of_argument(arguments.tree, arguments.workspace)
    session = Run(options, workspace, printer)
    if arguments.report:
        _check_writable(arguments.report)
    _tell_warnings(session.tree, arguments.quiet)
    printer.show(session.tree)
    if not arguments.quiet:
        where = f" on {session.robot_name} in {session.scene_name}, seed {options.seed}"
        console.print(Text.assemble((session.tree.name, "bold"), where))
    with printer, _interruptions() as reasons, _keys(session, reasons, console, arguments.quiet):
        report = session.execute(lambda: reasons[0] if reasons else "")
    if report.traceback and report.reason.startswith("internal error"):
        print(report.traceback, file=sys.stderr)
    print_summary(console, report)
    if arguments.report:
        report.write(arguments.report)
    return report.exit_code


def _tell_warnings(tree: Tree, quiet: bool) -> None:
    """Print what the tree's checks found that does not keep it from running.

    Raises:
        UserError: a comment in the tree's file allows what it cannot allow, or gives no reason.
    """
    problems = settled({tree.path: tree.warnings})
    if any(problem.severity == "error" for problem in problems):
        raise UserError(problems)
    if not quiet:
        print_findings(problems, stderr=True)


def _options(arguments: argparse.Namespace) -> RunOptions:
    lockstep = arguments.mode == "lockstep"
    if arguments.pace and not lockstep:
        raise UserError("--pace does not go with --mode realtime", hint="realtime runs on the wall clock")
    view = arguments.view
    implied = view is None and arguments.serve is None
    file = None if arguments.no_record else arguments.record or default_recording(arguments.tree)
    return RunOptions(
        tree=arguments.tree,
        robot=arguments.robot,
        scene=arguments.scene,
        overrides=_overrides(arguments.overrides),
        seed=arguments.seed,
        duration=arguments.duration or (math.inf if arguments.watch else DURATION),
        pace=1.0 if arguments.watch and lockstep and not arguments.pace else arguments.pace,
        mode=arguments.mode,
        hold=arguments.hold,
        watch=arguments.watch,
        sinks=Sinks(file=file, view=has_display() if implied else bool(view), serve=arguments.serve),
        view_optional=implied,
    )


def _overrides(texts: list[str]) -> dict[str, str]:
    values: dict[str, str] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        name = name.strip()
        if not equals or not name:
            raise UserError(f"--set {text!r} is not NAME=VALUE", hint="example: --set reach_distance=0.45")
        if name in values:
            raise UserError(f"--set {text!r}: {name!r} was set to {values[name]!r} before", hint="give each name once")
        values[name] = value
    return values


def _check_writable(path: Path) -> None:
    """Find out before the run that its report cannot be written after it."""
    try:
        with path.open("a", encoding="utf-8"):
            pass
    except OSError as error:
        hint = "valid: a file in a folder that is there and that you may write"
        raise UserError(f"the report cannot be written to {str(path)!r}: {error.strerror}", hint=hint) from error


@contextmanager
def _keys(session: Run, reasons: list[str], console: Console, quiet: bool) -> Iterator[None]:
    """Let keys stop and reset the robot and end the run, if somebody sits at a terminal."""
    if not keys.available():
        yield
        return

    def stop() -> None:
        session.raise_estop(_KEYBOARD, "a key was pressed")

    def reset() -> None:
        try:
            session.request_reset(_KEYBOARD)
        except HumanoidBtError as error:
            print(f"error: no reset: {error}", file=sys.stderr)

    def end() -> None:
        if not reasons:
            reasons.append("the key q")

    with keys.listening({" ": stop, "e": stop, "r": reset, "q": end}):
        if not quiet:
            console.print(keys.HELP, style="dim")
        yield


@contextmanager
def _interruptions() -> Iterator[list[str]]:
    """Turn Ctrl-C and its like into reasons to end the run; a second one ends it at once."""
    reasons: list[str] = []

    def note(number: int, _frame: FrameType | None) -> None:
        if reasons:
            raise KeyboardInterrupt
        reasons.append(_SIGNALS[signal.Signals(number)])

    before = {number: signal.signal(number, note) for number in _SIGNALS}
    try:
        yield reasons
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
