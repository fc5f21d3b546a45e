"""``humanoid-bt params``: the parameters of a recorded run, and how those of two differ."""

from __future__ import annotations

import argparse
from pathlib import Path

from humanoid_bt.campaign.reproduce import command_of
from humanoid_bt.cli.output import columns, print_lines
from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.review.newest import newest_recording
from humanoid_bt.review.parameters import as_yaml, changed_parameters, known_parameters, shown
from humanoid_bt.review.recording import open_recording
from humanoid_bt.review.setup import ParameterInfo
from humanoid_bt.session.report import ExitCode

_DIFF = Path("diff")
_DIFFERENT = 1


def params(arguments: argparse.Namespace) -> int:
    """Print the parameters of a run, or how those of two differ."""
    if arguments.paths[:1] == [_DIFF]:
        return _diff(arguments.paths[1:])
    if len(arguments.paths) > 1:
        raise UserError(
            f"params prints one recording, not {len(arguments.paths)}", hint="two: humanoid-bt params diff A B"
        )
    recording = open_recording(arguments.paths[0] if arguments.paths else newest_recording())
    print(as_yaml(recording, command_of(recording.path)), end="")
    return ExitCode.SUCCESS


def _diff(paths: list[Path]) -> int:
    if len(paths) != 2:
        raise UserError(f"params diff compares two, not {len(paths)}", hint="humanoid-bt params diff A B")
    changes = list(changed_parameters(*map(known_parameters, paths)))
    if changes:
        print_lines(f"{name}  {relative(path)}" for name, path in zip("AB", paths, strict=True))
        rows = [
            (c.name, f"{shown(c.before)} → {shown(c.after)}", f"{_origin(c.before)} → {_origin(c.after)}")
            for c in changes
        ]
        print_lines(columns(rows, indent=3))
    return _DIFFERENT if changes else ExitCode.SUCCESS


def _origin(parameter: ParameterInfo | None) -> str:
    return (parameter.origin if parameter else "") or "-"
