"""What a plant does that hears nothing any more, and when."""

from __future__ import annotations

from typing import Literal, get_args

SafeState = Literal["hold", "damp"]
"""What a plant does that hears nothing: hold the last position, or let go of it and only brake."""

SAFE_STATES: tuple[SafeState, ...] = get_args(SafeState)
"""Both of them."""

WATCHDOG = 0.020
"""Silence of the driver after which a plant goes to its safe state [s], unless it is told otherwise."""

LET_GO = 0.100
"""Silence of the driver after which it is a driver no more [s]: until then its next command is followed again."""
