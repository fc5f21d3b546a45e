"""Sizes of files: as people write them, and as they read them."""

from __future__ import annotations

import math

from humanoid_bt.core.units import written_quantity

_FACTORS = {"B": 1.0, "kB": 1e3, "KB": 1e3, "MB": 1e6, "GB": 1e9, "TB": 1e12}
VALID = "a size such as 500 MB or 20 GB"
"""What a size is, for messages."""


def read_size(text: str) -> int | None:
    """Return the bytes of a written size ("20 GB"), None if it is none above 0."""
    number, unit = written_quantity(text) or (math.nan, "")
    size = number * _FACTORS.get(unit, math.nan)
    return int(size) if 1 <= size < math.inf else None


def shown_size(size: float) -> str:
    """Return bytes as people read them ("1.3 GB")."""
    for unit in ("B", "kB", "MB", "GB"):
        if size < 999.5:
            return f"{size:.0f} {unit}" if unit == "B" or size >= 99.95 else f"{size:.1f} {unit}"
        size /= 1000
    return f"{size:.1f} TB"
