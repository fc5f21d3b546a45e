"""Numbers of the command line, and what is said where one is not valid."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import Any


def number(kind: Callable[[str], Any], valid: str, is_valid: Callable[[Any], bool]) -> Callable[[str], Any]:
    """Return what reads a number and says what would be valid if it is not."""

    def read(text: str) -> Any:
        try:
            value = kind(text)
        except ValueError:
            value = None
        if value is None or not is_valid(value):
            raise argparse.ArgumentTypeError(f"must be {valid}, not {text!r}")
        return value

    return read


positive = number(float, "a number above 0", lambda value: 0 < value < float("inf"))
phase = number(float, "a number from 0.1 to 3600", lambda value: 0.1 <= value <= 3600)
positive_int = number(int, "a whole number above 0", lambda value: value > 0)
seed = number(int, "a whole number, 0 or more", lambda value: value >= 0)
port = number(int, "a port from 1 to 65534", lambda value: 1 <= value <= 65534)
