"""``explain``: why a run stopped, fell or failed, from its recording."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from humanoid_bt.cli.output import print_lines, width
from humanoid_bt.core.errors import UserError
from humanoid_bt.review.explain import explain as explained
from humanoid_bt.session.options import RUNS
from humanoid_bt.session.report import ExitCode


def explain(arguments: argparse.Namespace) -> int:
    """Say why a run ended as it did."""
    recording = arguments.recording or _newest(RUNS)
    found = explained(recording, at=arguments.at, node=arguments.node, joint=arguments.joint)
    if arguments.json:
        print(json.dumps(found.to_dict(), indent=2, allow_nan=False))
    else:
        print_lines(found.text(width()).splitlines())
    return ExitCode.SUCCESS


def _newest(folder: Path) -> Path:
    """Return the recording that was written last.

    Raises:
        UserError: there is none.
    """
    files = [file for file in folder.glob("*.rrd") if file.is_file()]
    if not files:
        raise UserError(
            f"no recording in {str(folder)!r}",
            hint="humanoid-bt explain RECORDING; a run without --no-record writes one",
        )
    return max(files, key=lambda file: file.stat().st_mtime)
