"""Colours on a terminal."""

from __future__ import annotations

from py_trees.common import Status

from humanoid_bt.tree.show.looks import STATUS_COLORS, hexadecimal

STATUS_STYLES = {status: hexadecimal(STATUS_COLORS[status.name].any) for status in Status}
"""Those of the statuses, for a background that nobody knows."""
