"""Numbers of the command line, and what is said where one is not valid."""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from typing import Any

from humanoid_bt.core.sizes import VALID, read_size, shown_size
from humanoid_bt.core.units import factors
from humanoid_bt.record.parts import SMALLEST_PART
from humanoid_bt.session.limits import Limit

PHASE = Limit(float, "a number from 0.1 to 3600", lambda value: 0.1 <= value <= 3600, "s")
TIME = Limit(float, "a time, 0 or more", lambda value: 0 <= value < math.inf, "s")
PERCENT = Limit(float, "a number from 0 to 100", lambda value: 0 <= value <= 100)
COUNT = Limit(int, "a whole number above 0", lambda value: value > 0)


def size(text: str) -> int:
    """Read the size of a part of a recording."""
    found = read_size(text)
    if found is None or found < SMALLEST_PART:
        raise argparse.ArgumentTypeError(f"must be {VALID}, at least {shown_size(SMALLEST_PART)}, not {text!r}")
    return found


def number(limit: Limit) -> Callable[[str], Any]:
    """Return what reads a number and says what would be valid if it is not."""

    def read(text: str) -> Any:
        try:
            return limit.read(text)
        except ValueError as error:
            others = ", ".join(unit for unit in factors(limit.unit) if unit != limit.unit)
            more = f", in {limit.unit} or with a unit ({others})" if others else ""
            raise argparse.ArgumentTypeError(f"must be {limit.valid}{more}, not {text!r}") from error

    return read
