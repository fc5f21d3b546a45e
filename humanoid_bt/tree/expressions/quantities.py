"""Types of the values in expressions: truth, text, numbers with their dimension."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

from humanoid_bt.core.reading import is_finite
from humanoid_bt.core.units import DIGITS, UNITS, quantity

Exponents = tuple[int, int, int, int]
"""Powers of metre, second, radian, kilogram."""

_EXPONENTS: dict[str, Exponents] = {
    "m": (1, 0, 0, 0),
    "s": (0, 1, 0, 0),
    "rad": (0, 0, 1, 0),
    "kg": (0, 0, 0, 1),
    "m/s": (1, -1, 0, 0),
    "rad/s": (0, -1, 1, 0),
    "N": (1, -2, 0, 1),
    "Nm": (2, -2, 0, 1),
    "Hz": (0, -1, 0, 0),
}
assert set(_EXPONENTS) == set(UNITS)
_NAMES = {exponents: unit for unit, exponents in _EXPONENTS.items()}


@dataclass(frozen=True)
class Type:
    """Type of a value.

    Attributes:
        kind: what it is; ``anything`` if that is only known when it runs, ``node`` if it is no value.
        exponents: of a number, its dimension; None for a plain number, which goes with every unit.
    """

    kind: Literal["truth", "text", "number", "node", "anything"]
    exponents: Exponents | None = None

    @property
    def unit(self) -> str:
        """The SI unit as people write it, "" for none."""
        if self.exponents is None:
            return ""
        if self.exponents in _NAMES:
            return _NAMES[self.exponents]
        powers = zip(("m", "s", "rad", "kg"), self.exponents, strict=True)
        return " ".join(f"{name}^{power}" if power != 1 else name for name, power in powers if power)

    def __str__(self) -> str:
        names = {"truth": "true or false", "text": "text", "node": "a node", "anything": "anything"}
        if self.kind != "number":
            return names[self.kind]
        return f"a number in {self.unit}" if self.unit else "a plain number"

    def goes_with(self, other: Type) -> bool:
        """Return whether values of both types can be added or compared."""
        if "anything" in (self.kind, other.kind):
            return True
        if self.kind != other.kind:
            return False
        return self.exponents is None or other.exponents is None or self.exponents == other.exponents

    def times(self, other: Type, power: int = 1) -> Type:
        """Return the type of a product, or of a quotient with ``power`` -1."""
        if "anything" in (self.kind, other.kind):
            return ANYTHING
        mine, others = self.exponents or (0, 0, 0, 0), other.exponents or (0, 0, 0, 0)
        m, s, rad, kg = (a + power * b for a, b in zip(mine, others, strict=True))
        return Type("number", (m, s, rad, kg) if m or s or rad or kg else None)


TRUTH, TEXT, NUMBER, ANYTHING = Type("truth"), Type("text"), Type("number"), Type("anything")
NODE = Type("node")
"""Of a parameter that stands for a node."""


def number(unit: str) -> Type:
    """Return the type of a number with a unit of :data:`~humanoid_bt.core.params.UNITS`; "" for a plain one."""
    return Type("number", _EXPONENTS[unit]) if unit else NUMBER


def type_of(value: object) -> Type:
    """Return the type of a plain value."""
    if isinstance(value, bool):
        return TRUTH
    if isinstance(value, (int, float)):
        return NUMBER
    return TEXT if isinstance(value, str) else ANYTHING


_QUANTITY = re.compile(rf"({DIGITS}(?:[eE][-+]?\d+)?)(?:\s*(%|[A-Za-z]+(?:/[A-Za-z]+)?))?")
_PERCENT = "%"  # of a plain number


def read_quantity(text: str, start: int) -> tuple[float, str, int] | None:
    """Read a number and the unit behind it, if it has one.

    Returns:
        The number in SI units, its SI unit ("" for none) and where it ends; None if no number begins at ``start``.
    """
    match = _QUANTITY.match(text, start)
    if match is None:
        return None
    written, behind = match[1], match[2] or ""
    if behind == _PERCENT:
        return float(written) / 100, "", match.end()
    for unit in (behind, behind.partition("/")[0]):  # "2 m/s" is a speed, "2 m/speed" a quotient
        found = quantity(f"{written} {unit}") if unit else None
        if found is not None:
            return *found, match.start(2) + len(unit)
    value = float(written)
    return (int(written) if written.isdigit() and is_finite(value) else value), "", match.end(1)
