"""The folder of recordings: what is in it, what is to be kept, and what makes room for new ones."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.sizes import shown_size
from humanoid_bt.link.life import lives
from humanoid_bt.record.folder_limits import FolderLimits
from humanoid_bt.record.parts import first_of, is_recording

SUFFIX = ".rrd"
_OURS = re.compile(r"(?P<stem>(?P<tree>.+?)-(?P<began>\d{8}-\d{6})(?:-\d+)?)\.[^/]+", re.DOTALL)
_KEEP = ".keep"
_MOST_NAMED = 5


@dataclass(frozen=True)
class Recorded:
    """A recording that got its name from its run, TREE-DATE-TIME, with what lies beside it.

    Attributes:
        first: its file, or the first of its parts; it may be missing.
        tree: what ran.
        began: when, as the name says: by the clock on the wall where the run was.
        written: when its files were written last, by which recordings are in order [ns since 1970].
        parts: the files of the recording that are there, in order.
        beside: what the run left beside it: the log of control, the report.
        size: bytes of all of them.
        kept: whether somebody wants to keep it.
    """

    first: Path
    tree: str
    began: datetime
    written: int
    parts: tuple[Path, ...]
    beside: tuple[Path, ...]
    size: int
    kept: bool

    @property
    def is_written(self) -> bool:
        """Whether a run writes it now."""
        return any(lives(part.resolve()) for part in self.parts)

    def keep(self, wanted: bool) -> bool:
        """Keep it for good, or no longer; return whether that was so before.

        Raises:
            UserError: the file that says so cannot be made, or removed.
        """
        mark = self.first.with_suffix(_KEEP)
        try:
            if wanted:
                mark.touch()
            else:
                mark.unlink(missing_ok=True)
        except OSError as error:
            raise UserError(
                f"{relative(mark)!r} cannot be {'made' if wanted else 'removed'}: {error.strerror}"
            ) from error
        return self.kept == wanted

    def remove(self) -> None:
        """Remove all its files, the first one last: what is left half-way can be removed once more.

        Raises:
            OSError: one cannot be removed.
        """
        for path in (*self.beside, *reversed(self.parts)):
            path.unlink(missing_ok=True)


def log_beside(recording: Path) -> Path:
    """Return where control notes what happens in a recorded run, in realtime mode."""
    return recording.with_suffix(".control.log")


def report_beside(recording: Path) -> Path:
    """Return where the report of a recorded run is."""
    return recording.with_suffix(".json")


def stem_of(name: str) -> str:
    """Return what the names of all files of a recording begin with, TREE-DATE-TIME, if this is one of them."""
    match = _OURS.fullmatch(name)
    return match["stem"] if match else name


def files_in(folder: Path) -> list[Path]:
    """Return what is in a folder of recordings, nothing if it is not there.

    Raises:
        UserError: it cannot be read.
    """
    try:
        return list(folder.iterdir())
    except FileNotFoundError:
        return []
    except OSError as error:
        raise UserError(f"the folder {relative(folder)!r} cannot be read: {error.strerror}") from error


def recordings_in(folder: Path) -> list[Recorded]:
    """Return the recordings of a folder whose names come from their runs, those written last first.

    Nothing else is looked at.

    Raises:
        UserError: the folder cannot be read.
    """
    groups: dict[str, list[Path]] = {}
    for path in files_in(folder):
        if match := _OURS.fullmatch(path.name):
            groups.setdefault(match["stem"], []).append(path)
    found = [recorded for stem, files in groups.items() for recorded in _recorded(folder / f"{stem}{SUFFIX}", files)]
    return sorted(found, key=lambda recorded: (recorded.written, recorded.first.name), reverse=True)


def make_room(folder: Path, limits: FolderLimits) -> str:
    """Remove the oldest recordings of a folder until it keeps its limits; return what there is to tell of it.

    Those that are written now, or are to be kept, stay.
    """
    try:
        found = [recorded for recorded in recordings_in(folder) if not recorded.kept]
    except UserError as error:
        return error.problems[0].message
    count, size = len(found), sum(recorded.size for recorded in found)
    removed: list[Recorded] = []
    for recorded in reversed(found):
        if count <= limits.recordings and size <= limits.bytes:
            break
        if recorded.is_written:
            continue
        try:
            recorded.remove()
        except OSError as error:
            return f"the old recording {relative(recorded.first)!r} cannot be removed: {error.strerror}"
        removed.append(recorded)
        count, size = count - 1, size - recorded.size
    return _told(removed)


def _told(removed: list[Recorded]) -> str:
    if not removed:
        return ""
    names = [recorded.first.name for recorded in removed]
    more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
    freed = shown_size(sum(recorded.size for recorded in removed))
    what = "1 old recording was" if len(names) == 1 else f"{len(names)} old recordings were"
    return f"{what} removed, {freed}: {', '.join(names[:_MOST_NAMED])}{more}"


def _recorded(first: Path, files: list[Path]) -> Iterator[Recorded]:
    """Yield the recording that has these files, if one of them is a recording."""
    parts: list[Path] = []
    beside: list[Path] = []
    kept = False
    for path in sorted(files):
        if path.name == first.with_suffix(_KEEP).name:
            kept = True
        elif path.suffix == SUFFIX and first_of(path) == first and is_recording(path):
            parts.append(path)
        elif path in (log_beside(first), report_beside(first)) and path.is_file() and not path.is_symlink():
            beside.append(path)
    try:
        size = sum(path.stat().st_size for path in (*parts, *beside))
        written = max((path.stat().st_mtime_ns for path in parts), default=0)
    except OSError:  # one was removed meanwhile
        return
    match = _OURS.fullmatch(first.name)
    try:
        began = datetime.strptime(match["began"] if match else "", "%Y%m%d-%H%M%S")
    except ValueError:  # numbers that are no time: not ours
        return
    if parts and match:
        parts.sort(key=lambda part: (len(part.name), part.name))
        yield Recorded(first, match["tree"], began, written, tuple(parts), tuple(beside), size, kept)
