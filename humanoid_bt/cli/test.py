"""``humanoid-bt test``: running scenarios, and telling what came of them."""

from __future__ import annotations

import argparse
import json
from types import TracebackType
from typing import Self

from rich.live import Live
from rich.text import Text

from humanoid_bt.cli.console import SafeConsole
from humanoid_bt.cli.output import hanging
from humanoid_bt.cli.wording import INDENT, several
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.texts import one_line, printable
from humanoid_bt.files.whole import make_way
from humanoid_bt.session.report import ExitCode
from humanoid_bt.testing.junit import write_junit
from humanoid_bt.testing.scenario import Scenario
from humanoid_bt.testing.seeds import Seeds
from humanoid_bt.testing.suite import Result, Suite
from humanoid_bt.testing.trial import Trial

_GOOD, _BAD, _CUT = ("✓", "green"), ("✗", "red"), ("○", "yellow")
_MOST_SEEDS = 10
"""Most failing seeds of a scenario that are told in full."""


def test(arguments: argparse.Namespace) -> int:
    """Run scenarios and judge them; return the exit code."""
    seeds = Seeds.parse(arguments.seeds) if arguments.seeds is not None else None
    if arguments.junit is not None:
        _make_way(arguments)
        arguments.junit = arguments.junit.absolute()  # wherever skills go
    suite = Suite(arguments.names, arguments.workspace, seeds)
    console = SafeConsole()
    told = _Teller(console, suite, quiet=arguments.json)
    results: list[Result] = []
    interrupted = False
    try:
        with told:
            for result in suite.results(arguments.jobs, not arguments.no_record, told.progress):
                results.append(result)
                told.result(result)
    except KeyboardInterrupt:
        interrupted = True
    finally:
        if arguments.json:
            print(json.dumps([trial.to_dict() for result in results for trial in result.trials], indent=2))
        else:
            told.summary(results, interrupted)
        if arguments.junit is not None:
            write_junit(results, arguments.junit)
    if interrupted:
        return ExitCode.INTERRUPTED
    return ExitCode.FAILURE if any(result.failed for result in results) else ExitCode.SUCCESS


def _make_way(arguments: argparse.Namespace) -> None:
    """Find out that the results can be written, and remove older ones, which nobody shall take for these."""
    path = arguments.junit
    try:
        if path.is_file() and path.stat().st_size and b"<testsuites" not in path.read_bytes()[:1000]:
            message = f"--junit would overwrite {str(path)!r}, which is no file of results"
            raise UserError(message, hint="valid: an older one, or a name that is free")
        make_way(path)
    except OSError as error:
        hint = "valid: a file in a folder that is there and that you may write"
        raise UserError(f"the results cannot be written to {str(path)!r}: {error.strerror}", hint=hint) from error


class _Teller:
    """Prints a line per scenario, what failed in full, and on a terminal how far it is.

    Args:
        console: where it prints.
        suite: what is run.
        quiet: print nothing.
    """

    def __init__(self, console: SafeConsole, suite: Suite, quiet: bool) -> None:
        self._console, self._suite, self._quiet = console, suite, quiet
        self._done = self._failed = 0
        self._live: Live | None = None

    def __enter__(self) -> Self:
        if self._console.is_terminal and not self._quiet:
            self._live = Live(console=self._console, transient=True, auto_refresh=False)
            self._live.start()
            self._show("loading the robot")
        return self

    def __exit__(
        self, _kind: type[BaseException] | None, _error: BaseException | None, _traceback: TracebackType | None
    ) -> None:
        if self._live is not None:
            self._live.stop()

    def progress(self, scenario: Scenario, trial: Trial) -> None:
        """Show how far it is."""
        self._done += 1
        self._failed += not trial.passed
        self._show(f"{scenario.name}, seed {trial.seed}")

    def _show(self, what: str) -> None:
        if self._live is not None:
            failed = f", {self._failed} failed" if self._failed else ""
            line = f"{self._done} of {self._suite.total}{failed}  {one_line(what)}"
            self._live.update(Text(line, style="dim", no_wrap=True, overflow="ellipsis"), refresh=True)

    def result(self, result: Result) -> None:
        """Print what came of a scenario."""
        if self._quiet:
            return
        (sign, color), trials = _BAD if result.failed else _GOOD if result.whole else _CUT, result.trials
        count = several(len(trials), "seed") + (
            "" if result.whole else f" of {len(self._suite.seeds(result.scenario))}"
        )
        if result.failed and len(trials) > 1:
            count = f"{len(result.failed)} of {count} failed"
        simulated, taken = sum(trial.time for trial in trials), sum(trial.wall_time for trial in trials)
        dry = ", dry" if result.scenario.dry else ""
        name = printable(result.scenario.name)
        text = f"{count}, {simulated:.2f} s in {taken:.2f} s{dry}"
        line = Text("\n".join(hanging(f"{sign} {name:<{self._width}}  ", text)))
        line.stylize(color, 0, 1)
        line.stylize("bold", 2, 2 + len(name))
        self._console.print(line, soft_wrap=True)
        for trial in result.failed[:_MOST_SEEDS]:
            self._failure(trial)
        if left := result.failed[_MOST_SEEDS:]:
            seeds = ", ".join(str(trial.seed) for trial in left)
            self._print(INDENT[:2], f"... and seeds {seeds}")

    @property
    def _width(self) -> int:
        return min(max(len(scenario.name) for scenario in self._suite.scenarios), 24)

    def _failure(self, trial: Trial) -> None:
        self._print("  ", f"seed {trial.seed}: {trial.outcome}: {trial.reason}", "yellow")
        for failure in trial.failures:
            place = f"{failure.place}: " if failure.place.file else ""
            self._print(INDENT, f"{place}{failure.expectation}", "bold")
            self._print(INDENT + "  ", failure.moment, "red")
            for name, value in failure.values.items():
                self._print(f"{INDENT}    {one_line(name)}: ", value)
        for name, text in trial.further:
            self._print(f"{INDENT}{name:<11}", text, breaks=False)

    def _print(self, head: str, text: str, style: str = "", breaks: bool = True) -> None:
        """Print a text behind a head, wrapped; what is to be copied is not broken."""
        lines = hanging(head, one_line(text)) if breaks else [head + one_line(text)]
        line = Text("\n".join(lines))
        line.stylize(style, len(head))
        self._console.print(line, soft_wrap=True)

    def summary(self, results: list[Result], interrupted: bool) -> None:
        """Print how many passed."""
        failed = [result for result in results if result.failed]
        passed = sum(result.whole and not result.failed for result in results)
        parts = [f"{several(passed, 'scenario')} passed"] if passed or not failed else []
        parts += [f"{several(len(failed), 'scenario')} failed"] if failed else []
        if interrupted:
            parts.append(f"interrupted after {self._done} of {several(self._suite.total, 'run')}")
        self._console.print(Text(", ".join(parts), style=f"bold {'red' if failed or interrupted else 'green'}"))
