"""Names and patterns of them, as ``left_*``, by which files choose joints."""

from __future__ import annotations

import fnmatch
from collections.abc import Iterable


def matches(name: str, pattern: str) -> bool:
    """Return whether a pattern means a name: as it is, also ``knee[left]``, or with ``*``, ``?`` and ``[]``."""
    return name == pattern or fnmatch.fnmatchcase(name, pattern)


def matching(names: Iterable[str], pattern: str) -> list[str]:
    """Return the names that a pattern means, in their order."""
    return [name for name in names if matches(name, pattern)]
