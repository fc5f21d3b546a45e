"""The pytest plugin's part that counts what of tree files the tests have tried: ``--tree-coverage``."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from humanoid_bt.testing.coverage import TreeCoverage


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the options."""
    group = parser.getgroup("tree coverage", "what of tree files the tests have tried")
    group.addoption(
        "--tree-coverage",
        action="append",
        nargs="?",
        const="",
        default=[],
        metavar="PATH",
        help="count for these trees (file, folder or name; default: the workspace's), =PATH; can be repeated",
    )
    group.addoption(
        "--tree-coverage-fail-under", type=_percent, metavar="N", help="fail if less than N percent of them were tried"
    )
    group.addoption("--tree-coverage-html", type=Path, metavar="FILE", help="write their source with marks")
    group.addoption("--tree-coverage-json", type=Path, metavar="FILE", help="write it for programs, and for merging")


def pytest_configure(config: pytest.Config) -> None:
    """Begin to count, if it is asked for; tests that run in other processes count too."""
    options = (config.getoption(f"tree_coverage{name}") for name in ("", "_fail_under", "_html", "_json"))
    if any(option not in (None, []) for option in options):
        counts = _Worker() if hasattr(config, "workerinput") else _Counter(config)
        config.pluginmanager.register(counts, "humanoid_bt_tree_coverage")


def _percent(text: str) -> float:
    """Read a share."""
    try:
        share = float(text)
    except ValueError:
        share = -1.0
    if not 0 <= share <= 100:
        raise argparse.ArgumentTypeError(f"must be a number from 0 to 100, not {text!r}")
    return share


class _Worker:
    """Counts in a process of pytest-xdist; the one that started it has said so in the environment."""

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self) -> None:
        """Write down what was counted."""
        from humanoid_bt.testing.coverage import save

        save()


class _Counter:
    """Counts in the process that the user has started, and reports."""

    def __init__(self, config: pytest.Config) -> None:
        from humanoid_bt.core.errors import UserError
        from humanoid_bt.testing.coverage import counting, tree_files

        paths = [path for path in config.getoption("tree_coverage") if path]
        try:
            self._files = tree_files(paths, _workspace(config))
        except UserError as error:
            raise pytest.UsageError(f"--tree-coverage: {_told(error)}") from error
        here = config.invocation_params.dir
        self._html, self._json = (
            path and here / path for path in map(config.getoption, ("tree_coverage_html", "tree_coverage_json"))
        )
        self._least: float | None = config.getoption("tree_coverage_fail_under")
        self._stack = ExitStack()
        self._folder = self._stack.enter_context(counting())
        self._report: TreeCoverage | None = None
        self._problem = ""

    @pytest.hookimpl(tryfirst=True)
    def pytest_sessionfinish(self, session: pytest.Session) -> None:
        """Look at what was counted; the session fails if that is too little."""
        from humanoid_bt.core.errors import UserError
        from humanoid_bt.testing.coverage import coverage_in, save, tree_coverage

        save()
        try:
            self._report = tree_coverage(coverage_in(self._folder), self._files)
            self._write(self._report)
        except UserError as error:
            self._problem = _told(error)
        else:
            self._problem = self._report.missed(self._least) if self._least is not None else ""
        if self._problem and session.exitstatus == pytest.ExitCode.OK:
            session.exitstatus = pytest.ExitCode.TESTS_FAILED

    def pytest_terminal_summary(self, terminalreporter: pytest.TerminalReporter) -> None:
        """Print it."""
        terminalreporter.section("tree coverage")
        if self._report is not None:
            terminalreporter.write_line(self._report.text())
        if self._problem:
            terminalreporter.write_line(f"ERROR: {self._problem}", red=True, bold=True)

    def pytest_unconfigure(self) -> None:
        """Count no more."""
        self._stack.close()

    def _write(self, report: TreeCoverage) -> None:
        from humanoid_bt.testing.coverage import write
        from humanoid_bt.testing.coverage_page import page

        if self._html is not None:
            write(self._html, page(report))
        if self._json is not None:
            write(self._json, report.to_json())


def _told(error: Exception) -> str:
    """Return what is wrong, to be put behind a word that says so."""
    return str(error).removeprefix("error: ")


def _workspace(config: pytest.Config) -> Path:
    from humanoid_bt.files.workspace import workspace_above

    root, named = config.rootpath, config.getini("humanoid_bt_workspace")
    return root / named if named else workspace_above(root) or root
