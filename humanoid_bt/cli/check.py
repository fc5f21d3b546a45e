"""``humanoid-bt check``: the mistakes in files, for people, editors and programs."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

from humanoid_bt.campaign.check_files import KINDS
from humanoid_bt.checking.check import collect, findings, settled
from humanoid_bt.checking.codes import ALLOWABLE, CODES, find
from humanoid_bt.cli.findings import counted, print_findings
from humanoid_bt.cli.output import columns, hanging, print_lines
from humanoid_bt.cli.reports import as_json, as_sarif
from humanoid_bt.cli.wording import several
from humanoid_bt.core.errors import Problem, relative
from humanoid_bt.core.texts import one_line
from humanoid_bt.session.report import ExitCode


def check(arguments: argparse.Namespace) -> int:
    """Check files, all in one go; tell every finding once; return the exit code."""
    if arguments.explain is not None:
        _explain(arguments.explain)
        return ExitCode.SUCCESS
    files, missing = collect(arguments.paths, arguments.workspace)
    found = {path: findings(path, workspace, KINDS) for path, workspace in files.items()}
    problems = [*missing, *settled(found)]
    if arguments.format == "json":
        print(as_json(problems))
    elif arguments.format == "sarif":
        print(as_sarif(problems))
    else:
        _print(problems, found)
    failed = arguments.strict or any(problem.severity == "error" for problem in problems)
    return ExitCode.USAGE if problems and failed else ExitCode.SUCCESS


def _print(problems: Sequence[Problem], found: Mapping[Path, Sequence[Problem]]) -> None:
    spoiled = {problem.place.file for problem in problems if problem.place}
    for path, own in found.items():
        name = relative(path)
        if name not in spoiled and not any(problem.severity == "error" for problem in own):
            print(f"{one_line(name)}: ok")
    print_findings(problems)
    if problems:
        print(counted(problems) + (f" in {several(len(found), 'file')}" if found else ""))


def _explain(name: str) -> None:
    """Print what a code means, or list all of them."""
    if not name:
        print_lines(columns((code.name, code.severity, code.meaning) for code in CODES.values()))
        return
    code = find(name)
    print_lines(hanging(f"{code.name}  ", f"{code.severity}. {code.meaning}"))
    for title, text in (("wrong:", code.wrong), ("right:", code.right)):
        if text:
            print(f"\n{title}\n{textwrap.indent(text, '    ')}")
    if code.name in ALLOWABLE:
        print(f"\nto allow it, on the line it is about or above it:\n    # allow {code.name}: and why")
