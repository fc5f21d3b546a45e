"""The recording that is meant when none is named: the newest one."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.core.errors import UserError
from humanoid_bt.session.options import RUNS


def newest_recording() -> Path:
    """Return the newest recording of the folder of recordings.

    Raises:
        UserError: there is none.
    """
    found = sorted(RUNS.glob("*.rrd"), key=lambda path: path.stat().st_mtime)
    if not found:
        message = f"there is no recording in {str(RUNS.absolute())!r}"
        raise UserError(message, hint="name one, or make one: humanoid-bt run fetch")
    return found[-1]
