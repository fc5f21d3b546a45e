"""Digests of the files that what a campaign runs depends on, by which a change of one is found."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Iterable, Mapping
from pathlib import Path

from humanoid_bt.core.errors import relative, resolved
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.report import versions

_VERSION = "humanoid-bt"  # among the files, since what is run depends on it as well
_KEPT = 1000  # digests


def called(file: Path, workspace: Workspace) -> str:
    """Return what a file is called, seen from its workspace; its whole path if a file of a nearer one is called so."""
    for root in workspace.layers:
        if file.is_relative_to(resolved(root)):
            name = str(file.relative_to(resolved(root)))
            return name if find([name], workspace)[name] == root / name else str(file)
    return relative(file)


def find(names: Iterable[str], workspace: Workspace) -> dict[str, Path]:
    """Return the files that are called so now, by these names."""
    there = {name: [file for root in workspace.layers if (file := root / name).exists()] for name in names}
    return {name: files[0] if files else Path(name) for name, files in there.items()}


def digests(files: Mapping[str, Path]) -> dict[str, str]:
    """Return digests of what files hold, by what these are called, and this version; "" of one that cannot be read."""
    return {**{name: _digest(file) for name, file in files.items()}, _VERSION: versions()[_VERSION]}


def changes(before: Mapping[str, str], after: Mapping[str, str]) -> list[str]:
    """Return the names of the files whose digests differ."""
    return sorted(name for name in {*before, *after} if before.get(name) != after.get(name))


def _digest(file: Path) -> str:
    try:
        status = file.stat()
        return _digest_of(file, status.st_ino, status.st_size, status.st_mtime_ns)
    except OSError:
        return ""


@functools.lru_cache(maxsize=_KEPT)
def _digest_of(file: Path, *_state: int) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()[:16]
