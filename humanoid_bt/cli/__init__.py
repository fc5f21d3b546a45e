"""The command line, ``humanoid-bt``: its commands, their arguments, and what they print."""

from __future__ import annotations

import argparse
import importlib
import sys
import traceback
from collections.abc import Sequence

from humanoid_bt.cli.arguments import parser
from humanoid_bt.cli.findings import counted, print_findings
from humanoid_bt.cli.output import standard_streams
from humanoid_bt.core.early import raise_it
from humanoid_bt.core.errors import HumanoidBtError, UserError
from humanoid_bt.plant.opengl import see_that_mujoco_loads
from humanoid_bt.session.report import ExitCode


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code."""
    before = sys.stdout, sys.stderr
    out, _ = standard_streams()
    try:
        code = _guarded(argv)
        out.flush()
        if out.problem:
            print(f"error: the output could not be written: {out.problem}", file=sys.stderr)
            return code or ExitCode.ERROR
        return code
    finally:
        sys.stdout, sys.stderr = before


def _guarded(argv: Sequence[str] | None) -> int:
    try:
        return int(_dispatch(parser().parse_args(argv)))
    except UserError as error:
        _print_problems(error)
        return ExitCode.USAGE
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return ExitCode.INTERRUPTED
    except HumanoidBtError as error:
        print(f"error: {error}", file=sys.stderr)
        return ExitCode.ERROR
    except Exception:
        traceback.print_exc()
        print("internal error: please report it with the lines above", file=sys.stderr)
        return ExitCode.ERROR


def _print_problems(error: UserError) -> None:
    errors = [problem for problem in error.problems if problem.severity == "error"]
    print_findings(errors, stderr=True)
    if len(errors) > 1:
        print(counted(errors), file=sys.stderr)


_COMMANDS = {
    "init": "init",
    "run": "run",
    "bench": "bench",
    "campaign": "campaign",
    "fmt": "fmt",
    "test": "test",
    "schema": "schema",
    "show": "show",
    "check": "check",
    "coverage": "coverage",
    "explain": "explain",
    "trees": "inspect",
    "nodes": "inspect",
    "skills": "inspect",
    "scenes": "inspect",
    "sources": "inspect",
    "robots": "inspect",
    "scenarios": "inspect",
    "diff": "diff",
    "export": "export",
    "params": "params",
    "replay": "replay",
    "estop": "estop",
    "reset": "remote",
    "status": "remote",
    "plant": "plant",
    "interfaces": "interfaces",
    "recordings": "recordings",
    "keep": "recordings",
}
"""Command -> the module with a function of its name; imported only when it is asked for."""


def _dispatch(arguments: argparse.Namespace) -> int:
    see_that_mujoco_loads()
    module = importlib.import_module(f"humanoid_bt.cli.{_COMMANDS[arguments.command]}")
    raise_it()
    code: int = getattr(module, arguments.command)(arguments)
    return code
