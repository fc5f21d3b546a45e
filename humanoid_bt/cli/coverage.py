"""``humanoid-bt coverage``: what of tree files was tried, from what was counted while trees ran."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from humanoid_bt.cli.output import width
from humanoid_bt.session.report import ExitCode
from humanoid_bt.testing.coverage import coverage_in, tree_coverage, tree_files, write
from humanoid_bt.testing.coverage_page import page


def coverage(arguments: argparse.Namespace) -> int:
    """Show what was tried, and write it if asked to; return the exit code."""
    files = tree_files(arguments.trees, arguments.workspace or Path())
    report = tree_coverage(coverage_in(*arguments.data), files)
    print(report.text(width()))
    if arguments.html is not None:
        write(arguments.html, page(report))
    if arguments.json is not None:
        write(arguments.json, report.to_json())
    missed = report.missed(arguments.fail_under or 0.0)  # a file with mistakes is not even enough for that
    if missed:
        print(f"error: {missed}", file=sys.stderr)
    if report.problems:
        return ExitCode.USAGE
    return ExitCode.FAILURE if missed else ExitCode.SUCCESS
