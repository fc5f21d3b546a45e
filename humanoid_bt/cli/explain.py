"""``explain``: why a run stopped, fell or failed, from its recording."""

from __future__ import annotations

import argparse
import json

from humanoid_bt.cli.output import print_lines, width
from humanoid_bt.review.explain import explain as explained
from humanoid_bt.review.newest import newest_recording
from humanoid_bt.session.report import ExitCode


def explain(arguments: argparse.Namespace) -> int:
    """Say why a run ended as it did."""
    recording = arguments.recording or newest_recording()
    found = explained(recording, at=arguments.at, node=arguments.node, joint=arguments.joint)
    if arguments.json:
        print(json.dumps(found.to_dict(), indent=2, allow_nan=False))
    else:
        print_lines(found.text(width()).splitlines())
    return ExitCode.SUCCESS
