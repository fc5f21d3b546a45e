"""A recorded run as a test: it fails until what failed then is mended."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.review.replay import Replay

_TEXT = '''\
"""{title}

It was recorded, and is run again with the files as they are now; it fails until what went wrong then is mended.
Recorded: {recorded}
"""

from pathlib import Path

import humanoid_bt as hbt

RECORDING = Path(__file__).parent / {recording}
WORKSPACE = Path(__file__).parent / {workspace}


def test_{name}() -> None:
    again = hbt.replay(RECORDING, files="current", workspace=WORKSPACE)
    assert again.passes, again
'''


def write_test(replay: Replay, path: Path, workspace: Path) -> None:
    """Write a test that runs a recorded run again.

    Args:
        replay: of it.
        path: the test's file.
        workspace: where the test looks up what the run was made of.

    Raises:
        UserError: the file exists, or cannot be written, or is none that pytest finds.
    """
    shown = relative(path)
    if not re.fullmatch(r"test_\w+\.py", path.name):
        raise UserError(f"pytest does not find {shown!r}", hint="valid: test_NAME.py")
    recorded = " ".join(f"{replay.recorded_outcome}: {replay.recorded_reason}".split()).replace('"""', "'''")
    text = _TEXT.format(
        title=f"A run of {Path(replay.recording).stem} that ended with: {replay.recorded_outcome or 'no end'}.",
        recorded=recorded.replace("\\", "/"),
        recording=_from(path, Path(replay.recording)),
        workspace=_from(path, workspace),
        name=path.stem.removeprefix("test_"),
    )
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise UserError(f"{shown!r} exists", hint="give another name") from None
    except OSError as error:
        raise UserError(f"{shown!r} cannot be written: {error.strerror}") from error


def _from(test: Path, file: Path) -> str:
    """Return the path of a file from a test's folder, as Python writes it."""
    return json.dumps(os.path.relpath(file.absolute(), test.absolute().parent))
