"""Units: what quantities may be written in, and what they are in SI units."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

_UNITS: dict[str, dict[str, float]] = {  # declared unit -> what may be written, and its factor
    "m": {"m": 1.0, "cm": 0.01, "mm": 0.001},
    "s": {"s": 1.0, "ms": 0.001, "min": 60.0},
    "rad": {"rad": 1.0, "deg": math.pi / 180},
    "m/s": {"m/s": 1.0, "cm/s": 0.01},
    "rad/s": {"rad/s": 1.0, "deg/s": math.pi / 180},
    "kg": {"kg": 1.0, "g": 0.001},
    "N": {"N": 1.0},
    "Nm": {"Nm": 1.0},
    "Hz": {"Hz": 1.0},
}
UNITS = tuple(_UNITS)
"""SI units that a parameter can declare."""

_DUST = 1e-6
"""What is smaller is said as 0: sums and differences of floats leave such."""

_EXPONENT = re.compile(r"^[-+]?(?:\d+\.?\d*|\.\d+)[eE][-+]?\d+$")  # YAML 1.1 reads 1e-3 as text
_QUANTITY = re.compile(r"^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*([A-Za-z/]+)\s*$")


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
            return written[0] * known[written[1]], unit
    return None


def factors(unit: str) -> Mapping[str, float]:
    """Return the units in which a quantity of an SI unit may be written, each with its size in that; none for ""."""
    return _UNITS.get(unit, {})


def base_unit(text: str) -> str | None:
    """Return the SI unit of a written quantity ("45 cm" -> "m"), None if it is none."""
    found = quantity(text)
    return found[1] if found else None


def in_words(value: float, unit: str, digits: int = 2) -> str:
    """Return a quantity as people say it: 0.41, 1 s, 60 deg.

    Args:
        value: in its SI unit.
        unit: the SI unit, "" for none.
        digits: most digits behind the point; two fewer of an angle.
    """
    if unit.startswith("rad"):
        value, unit, digits = math.degrees(value), f"deg{unit[3:]}", max(digits - 2, 0)
    number = f"{value:z.{digits}f}"
    if not float(number) and abs(value) > _DUST:
        return f"{value:.1g} {unit}".rstrip()
    return f"{number.rstrip('0').rstrip('.') if digits else number} {unit}".rstrip()


def both_in_words(one: float, other: float, unit: str) -> tuple[str, str]:
    """Return two quantities as people say them, with as many digits as it takes to tell them apart."""
    for digits in range(2, 8):
        words = in_words(one, unit, digits), in_words(other, unit, digits)
        if words[0] != words[1] or one == other:
            break
    return words
