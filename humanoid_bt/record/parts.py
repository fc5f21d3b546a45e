"""The parts of a recording: files of a bounded size, each of which can be opened alone or with the others."""

from __future__ import annotations

import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

PART_SIZE = 500_000_000
"""Bytes from which on a recording goes on in another file; about 20 minutes of a run."""

SMALLEST_PART = 10_000_000
"""The least that can be asked for: every file begins with the whole scene."""

MAGIC = b"RRF2"
"""What every recording begins with."""

_PART = re.compile(r"(?P<stem>.+)\.part(?P<number>\d{3,})", re.DOTALL)


def part_of(first: Path, number: int) -> Path:
    """Return the name of a part: ``run.rrd``, ``run.part002.rrd``."""
    return first if number == 1 else first.with_stem(f"{first.stem}.part{number:03}")


def first_of(part: Path) -> Path:
    """Return the first part of the recording that a part belongs to."""
    match = _PART.fullmatch(part.stem)
    return part.with_stem(match["stem"]) if match else part


def parts_of(path: Path) -> list[Path]:
    """Return all parts there are of a recording, in order.

    Args:
        path: of any part of it.
    """
    first = first_of(path)
    found: list[tuple[int, Path]] = []
    try:
        entries = list(first.parent.iterdir())
    except OSError:
        return []
    for entry in entries:
        match = _PART.fullmatch(entry.stem)
        if entry.name == first.name:
            found.append((1, entry))
        elif match and match["stem"] == first.stem and entry.suffix == first.suffix:
            found.append((int(match["number"]), entry))
    return [entry for _, entry in sorted(found)]


def missing_among(parts: Iterable[Path]) -> list[int]:
    """Return the numbers of the parts that are not among those of a recording, though a later one is."""
    numbers = {int(match["number"]) if (match := _PART.fullmatch(part.stem)) else 1 for part in parts}
    return sorted(set(range(1, max(numbers))) - numbers)


def is_recording(path: Path) -> bool:
    """Return whether a file, and no link to one, holds a recording."""
    try:
        if path.is_symlink() or not path.is_file():
            return False
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except OSError:
        return False


def remove_further(first: Path) -> None:
    """Remove the further parts of an older recording, which this one overwrites."""
    with suppress(OSError):
        for part in parts_of(first):
            if part.name != first.name and is_recording(part):
                part.unlink()
