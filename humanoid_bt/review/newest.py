"""Which recording is meant where none is named: the newest one."""

from __future__ import annotations

import stat
from pathlib import Path

from humanoid_bt.core.errors import UserError
from humanoid_bt.record.folder import SUFFIX, files_in
from humanoid_bt.session.options import RUNS


def newest_recording(folder: Path = RUNS) -> Path:
    """Return the recording in a folder that was written last.

    Raises:
        UserError: there is none, or the folder cannot be read.
    """
    found = [(written, path) for path in files_in(folder) if path.suffix == SUFFIX and (written := _written(path))]
    if not found:
        hint = "name one, or record a run: humanoid-bt run TREE"
        raise UserError(f"there is no recording in {str(folder)!r}", hint=hint)
    return max(found)[1]


def _written(path: Path) -> int:
    """Return when a file was written last [ns since 1970], 0 for none that holds something."""
    try:
        status = path.stat()
    except OSError:  # it was removed meanwhile, or is a link to nothing
        return 0
    return status.st_mtime_ns if stat.S_ISREG(status.st_mode) and status.st_size else 0
