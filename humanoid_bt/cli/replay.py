"""``replay``: running a recorded run again."""

from __future__ import annotations

import argparse
import json
import shlex
import sys
from pathlib import Path

from humanoid_bt.cli.overrides import overrides
from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import workspace_above
from humanoid_bt.review.newest import newest_recording
from humanoid_bt.review.replay import replay as replay_recording
from humanoid_bt.review.replay_test import write_test
from humanoid_bt.session.report import ExitCode


def replay(arguments: argparse.Namespace) -> int:
    """Run a recording again; return the exit code."""
    if arguments.to_test and (arguments.tree or arguments.overrides):
        raise UserError("--to-test does not go with --tree or --set", hint="a test runs the tree that was recorded")
    test = Path(arguments.to_test) if arguments.to_test else None
    workspace = arguments.workspace
    if test is not None and workspace is None:
        workspace = workspace_above(test.absolute().parent) or Path.cwd()
    done = replay_recording(
        arguments.recording or newest_recording(),
        tree=arguments.tree,
        parameters=overrides(arguments.overrides),
        files="current" if arguments.current or test is not None else "recorded",
        workspace=workspace,
    )
    print(json.dumps(done.to_dict(), indent=2) if arguments.json else done)
    if test is not None:
        write_test(done, test, workspace)
        now = "passes already" if done.passes else "fails now, until what went wrong is mended"
        keep = shlex.join(["humanoid-bt", "keep", str(done.recording)])
        told = f"{test} {now}; it needs the recording, which this keeps: {keep}"
        print(told, file=sys.stderr if arguments.json else sys.stdout)
    return ExitCode.SUCCESS if done.identical else ExitCode.FAILURE
