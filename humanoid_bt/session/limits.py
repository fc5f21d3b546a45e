"""Which numbers a run takes: one place for the command line and for Python."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.units import factors, quantity


@dataclass(frozen=True)
class Limit:
    """Which numbers an argument takes.

    Attributes:
        kind: whole numbers or any.
        valid: the same in words.
        holds: whether a number is one of them.
        unit: the SI unit that it is in; as text it may be written in others ("2 min").
    """

    kind: type[int] | type[float]
    valid: str
    holds: Callable[[float], bool]
    unit: str = ""

    def take(self, value: Any, name: str) -> float:
        """Return a value as a number.

        Args:
            value: what was given for the argument.
            name: the argument's.

        Raises:
            UserError: it is none that is valid.
        """
        written = quantity(value) if isinstance(value, str) and self.unit else None
        number = written[0] if written and written[1] == self.unit else self._number(value)
        if number is None or not self.holds(number):
            hint = f"in {self.unit}, or as text with its unit: {', '.join(factors(self.unit))}" if self.unit else ""
            raise UserError(f"{name!r} must be {self.valid}, not {value!r}", hint=hint)
        return number

    def read(self, text: str) -> float:
        """Return the number that a text holds.

        Raises:
            ValueError: it holds none that is valid.
        """
        written = quantity(text)
        if written is not None and written[1] == self.unit:
            return self.take(written[0], "it")
        return self.take(self.kind(text), "it")

    def _number(self, value: Any) -> float | None:
        if isinstance(value, (bool, str)):
            return None
        try:
            return operator.index(value) if self.kind is int else float(value)
        except (TypeError, ValueError):
            return None


DURATION = Limit(float, "a number above 0", lambda value: value > 0, "s")
MOMENT = Limit(float, "a number, 0 or more", lambda value: value >= 0, "s")
HOLD = Limit(float, "a number above 0", lambda value: 0 < value < math.inf, "s")
PACE = Limit(float, "a number from 0.001 on", lambda value: 1e-3 <= value < math.inf)
POSITIVE = Limit(float, "a number above 0", lambda value: 0 < value < math.inf)
FORCE = Limit(float, "at most 10000 N in each direction", lambda value: abs(value) <= 10_000)
SEED = Limit(int, "a whole number, 0 or more", lambda value: value >= 0)
PORT = Limit(int, "a port from 1 to 65534", lambda value: 1 <= value <= 65534)
