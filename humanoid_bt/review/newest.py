"""Which recording is meant where none is named: the newest one."""

from __future__ import annotations

from pathlib import Path

from humanoid_bt.core.errors import UserError
from humanoid_bt.session.options import RUNS


def newest_recording(folder: Path = RUNS) -> Path:
    """Return the recording in a folder that was written last.

    Raises:
        UserError: there is none.
    """
    try:
        found = [path for path in folder.glob("*.rrd") if path.is_file() and path.stat().st_size]
        return max(found, key=lambda path: (path.stat().st_mtime_ns, path.name))
    except (ValueError, OSError):
        hint = "name one, or record a run: humanoid-bt run TREE"
        raise UserError(f"there is no recording in {str(folder)!r}", hint=hint) from None
