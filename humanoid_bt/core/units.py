"""Units: what quantities may be written in, what they are in SI units, and how people read them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from decimal import Decimal
from typing import Any

_DEGREE = math.pi / 180  # rad

_UNITS: dict[str, dict[str, float]] = {  # declared unit -> what may be written, and its factor
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "rad": {"rad": 1.0, "deg": _DEGREE},
    "m/s": {"m/s": 1.0, "cm/s": 0.01},
    "rad/s": {"rad/s": 1.0, "deg/s": _DEGREE},
    "kg": {"kg": 1.0, "g": 0.001},
    "N": {"N": 1.0},
    "Nm": {"Nm": 1.0},
    "Hz": {"Hz": 1.0},
}
UNITS = tuple(_UNITS)
"""SI units that a parameter can declare."""

_SMALL = 0.1
"""A length below this [m] is given in cm; of other numbers below it the first digits count."""

_LARGE = 1e6
"""Numbers from here on are given with an exponent."""

_DUST = 1e-6
"""What is smaller is 0: sums and differences of floats leave such."""

_FINEST = 6  # further digits at most

DIGITS = r"(?:\d+(?:\.\d*)?|\.\d+)"
"""Digits of a number as people write it, as a regular expression: 45, 4.5, .45."""

_EXPONENT = re.compile(rf"^[-+]?{DIGITS}[eE][-+]?\d+$")  # YAML 1.1 reads 1e-3 as text
_QUANTITY = re.compile(rf"^\s*([-+]?{DIGITS}(?:[eE][-+]?\d+)?)\s*([A-Za-z/]+)\s*$")


def is_number_text(text: str) -> bool:
    """Return whether text is a number that YAML 1.1 takes for text (``1e-3``)."""
    return _EXPONENT.match(text) is not None


def written_quantity(text: str) -> tuple[float, str] | None:
    """Return number and unit of a quantity as they are written ("45 cm" -> 45, "cm"), None if it is none."""
    match = _QUANTITY.match(text)
    return (float(match[1]), match[2]) if match else None


def quantity(text: str) -> tuple[float, str] | None:
    """Return a written quantity in its SI unit ("45 cm" -> 0.45, "m"), None if it is none."""
    written = written_quantity(text)
    for unit, known in _UNITS.items():
        if written and written[1] in known:
            return in_si(written[0], known[written[1]]), unit
    return None


def in_si(number: float, factor: float) -> float:
    """Return a written number in the SI unit: 35 cm as 0.35, where floats multiply to 0.35000000000000003."""
    if factor in (1.0, _DEGREE):
        return number * factor
    return float(Decimal(repr(number)) * Decimal(repr(factor)))


def shown_quantity(value: Any, unit: str = "") -> str:
    """Return a value in SI units as people read it, an angle also in degrees; a word for what is no number."""
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(shown_quantity(part, unit) for part in value)}]"
    if not isinstance(value, (int, float)):
        return str(value)
    degrees = f" ({readable(round(math.degrees(value), 1))} deg)" if unit == "rad" and value else ""
    return f"{value:g}{degrees}"


def spaced(value: Any) -> Any:
    """Return a written value with one blank before each unit: "60deg" as "60 deg"."""
    if isinstance(value, (list, tuple)):
        return [spaced(part) for part in value]
    written = written_quantity(value) if isinstance(value, str) else None
    return f"{written[0]:g} {written[1]}" if written else value


def factors(unit: str) -> Mapping[str, float]:
    """Return the units in which a quantity of an SI unit may be written, each with its size in that; none for ""."""
    return _UNITS.get(unit, {})


def base_unit(text: str) -> str | None:
    """Return the SI unit of a written quantity ("45 cm" -> "m"), None if it is none."""
    found = quantity(text)
    return found[1] if found else None


def readable(value: object, unit: str = "", more: int = 0) -> str:
    """Return a value as people read it: small lengths in cm, angles in degrees, no more digits than help.

    Args:
        value: in its SI unit, if it is a number.
        unit: that unit, "" for none.
        more: digits beyond the usual ones.
    """
    if isinstance(value, bool) or value is None:
        return {True: "true", False: "false", None: "null"}[value]
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(readable(part, more=more) for part in value)}]"
    if not isinstance(value, (int, float)):
        return str(value)
    decimals = 2
    if unit == "m" and abs(value) < _SMALL:
        value, unit, decimals = 100 * value, "cm", 1
    elif unit in ("rad", "rad/s"):
        value, unit = math.degrees(value), unit.replace("rad", "deg")
        decimals = 1 if abs(value) < 10 else 0
    text = _digits(value, decimals, more)
    return f"{text} {unit}" if unit else text


def nonzero(value: float) -> str:
    """Return a number without what is behind the point, or its first digit if nothing else would be left of it."""
    return f"{value:z.0f}" if abs(value) >= 1 else f"{value:z.1g}"


def readable_pair(one: object, other: object, unit: str = "") -> tuple[str, str]:
    """Return two values as people read them, with as many digits as it takes to tell them apart."""
    first, second = readable_apart((one, other), unit)
    return first, second


def readable_apart(values: Sequence[object], unit: str = "") -> list[str]:
    """Return values as people read them, all with as many digits as it takes to tell different ones apart."""
    for more in range(_FINEST):
        texts = [readable(value, unit, more) for value in values]
        meant = dict(zip(texts, values, strict=True))
        if all(meant[text] == value for text, value in zip(texts, values, strict=True)):
            break
    return texts


def readable_ranges(ranges: Sequence[tuple[Any, Any]], unit: str = "") -> list[str]:
    """Return ranges as people read them, all with as many digits as it takes to tell the ends of each apart."""
    for more in range(_FINEST):
        ends = [(readable(low, unit, more), readable(high, unit, more)) for low, high in ranges]
        if all((texts[0] == texts[1]) == (low == high) for texts, (low, high) in zip(ends, ranges, strict=True)):
            break
    return [low if low == high else f"{low} to {high}" for low, high in ends]


def _digits(value: float, decimals: int, more: int) -> str:
    if isinstance(value, int):
        return str(value)
    if not abs(value) < _LARGE:  # nor are infinity and NaN
        return f"{value:.{6 + more}g}"
    if abs(value) < _DUST:
        return "0"
    if decimals == 2 and abs(value) < _SMALL:
        return f"{value:z.{2 + more}g}"
    text = f"{value:z.{decimals + more}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text
