"""``humanoid-bt run``: from the arguments to the exit code."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import Any

from rich.text import Text

from humanoid_bt.cli import keyboard, keys
from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.findings import print_findings
from humanoid_bt.cli.overrides import overrides, sources
from humanoid_bt.cli.printer import Printer, print_summary
from humanoid_bt.core import forks
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.files.whole import make_way
from humanoid_bt.session.report import ExitCode, Report
from humanoid_bt.session.session import Session

_SIGNALS = {signal.SIGINT: "Ctrl-C", signal.SIGTERM: "SIGTERM", signal.SIGHUP: "the terminal was closed"}


def run(arguments: argparse.Namespace) -> int:
    """Run a tree; return the exit code."""
    if arguments.report:
        _make_way(arguments.report)
        arguments.report = arguments.report.absolute()  # wherever skills go
    console = SafeConsole()
    printer = Printer(console, arguments.quiet)
    if arguments.breakpoints and not keys.available():
        message = "--break pauses the run, and nobody is at a terminal to continue it"
        raise UserError(message, hint="run it in a terminal, or from Python: session.break_at()")
    session = _session(arguments, printer)
    for where in arguments.breakpoints:
        session.break_at(where)
    if not arguments.quiet:
        print_findings(session.tree.warnings, stderr=True)
    printer.show(session.tree)
    if not arguments.quiet:
        where = f" on {session.robot_name} in {session.scene_name}, seed {arguments.seed}"
        console.print(Text.assemble((session.tree.name, "bold"), where))
    with printer, _interruptions(session), keyboard.connected(session, console, printer, arguments.quiet) as attended:
        report = _report(session, attended)
    if report.traceback and report.reason.startswith("internal error"):
        print(report.traceback, file=sys.stderr)
    lost = arguments.report and not _written(report, arguments.report)
    print_summary(console, report)
    return report.exit_code or (ExitCode.ERROR if lost else ExitCode.SUCCESS)


def _session(arguments: argparse.Namespace, printer: Printer) -> Session:
    view = arguments.view
    implied = view is None and arguments.serve is None
    return Session(
        arguments.tree,
        workspace=arguments.workspace,
        robot=arguments.robot,
        scene=arguments.scene,
        body=arguments.body,
        perception=sources(arguments.perception),
        parameters=_parameters(arguments),
        seed=arguments.seed,
        duration=arguments.duration,
        on_estop=arguments.on_estop,
        pace=arguments.pace,
        mode=arguments.mode or ("realtime" if arguments.plant else "lockstep"),
        hold=arguments.hold,
        plant=arguments.plant,
        plant_key=arguments.key,
        watch=arguments.watch,
        gateway=arguments.gateway,
        record=not arguments.no_record and (arguments.record or True),
        record_part_size=arguments.record_part_size,
        view="auto" if implied else bool(view),
        serve=arguments.serve,
        camera="auto" if arguments.camera == "auto" else arguments.camera == "on",
        listener=printer,
    )


def _report(session: Session, attended: bool) -> Report:
    """Run to the end; return the report, which is there too if somebody does not wait for it.

    Raises:
        KeyboardInterrupt: there is none, for the run had not begun.
    """
    try:
        return session.run(attended=attended)
    except KeyboardInterrupt:
        if not session.outcome:
            raise
        session.close()  # if the second one came before it was
        return session.report


def _parameters(arguments: argparse.Namespace) -> dict[str, Any]:
    """Return what the tree's parameters are given."""
    values = overrides(arguments.overrides)
    if arguments.params is None:
        return values
    from humanoid_bt.review.parameters import given_parameters

    return {**given_parameters(arguments.params), **values}


def _make_way(path: Path) -> None:
    """Remove an older report, which nobody shall take for this run's; find out that a new one can be written."""
    if path.suffix == ".rrd":
        message = f"--report is JSON, and {relative(path)!r} is called like a recording"
        raise UserError(message, hint=f"{path.with_suffix('.json')}")
    try:
        if path.is_file() and path.stat().st_size and not _is_report(path):
            message = f"--report would overwrite {relative(path)!r}, which is no report"
            raise UserError(message, hint="valid: an older report, or a name that is free")
        make_way(path)
    except OSError as error:
        hint = "valid: a file in a folder that is there and that you may write"
        raise UserError(f"the report cannot be written to {relative(path)!r}: {error.strerror}", hint=hint) from error


def _is_report(path: Path) -> bool:
    try:
        content = json.loads(path.read_bytes())
    except ValueError:
        return False
    return isinstance(content, dict) and "outcome" in content


def _written(report: Report, path: Path) -> bool:
    """Write the report; if that is not possible any more, tell it and return False."""
    try:
        report.write(path)
    except UserError as error:
        print_findings(error.problems, stderr=True)
        return False
    return True


@contextmanager
def _interruptions(session: Session) -> Iterator[None]:
    """Let Ctrl-C and its like end the run; a second one ends it at once."""
    noted, program = False, os.getpid()

    def note(number: int, _frame: FrameType | None) -> None:
        nonlocal noted
        if os.getpid() != program:
            forks.die_of(number)
        if noted or session.outcome == "interrupted":
            raise KeyboardInterrupt
        noted = True
        session.interrupt(_SIGNALS[signal.Signals(number)])

    ignored = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN  # nohup
    heard = [number for number in _SIGNALS if not (ignored and number == signal.SIGHUP)]
    before = {number: signal.signal(number, note) for number in heard}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
