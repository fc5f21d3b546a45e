"""What varies from trial to trial: values that are all tried, and values that are drawn for each trial.

What is drawn depends on the trial's seed and on what it is drawn for, and on nothing else: another campaign with the
same seeds draws the same, and can be compared with this one seed by seed.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import Any, ClassVar

from humanoid_bt.core.errors import Problem, UserError
from humanoid_bt.core.items import Item
from humanoid_bt.core.params import Param
from humanoid_bt.core.reading import convert

BETWEEN = ".."
"""``LOW .. HIGH``: a value that is drawn between two ends, each as likely as any other."""

_DIGITS = 6  # of a drawn value, behind the place of the first one of HIGH - LOW, so that people can type it again


@dataclass(frozen=True)
class Variation:
    """What a file or a command line gives for something that may vary.

    Attributes:
        values: all that are to be tried.
        ends: between which it is drawn for each trial, None if it is not; then there are no values.
    """

    values: tuple[Item, ...] = ()
    ends: tuple[Item, Item] | None = None

    described: ClassVar[str] = "value, list of values, or LOW .. HIGH"
    """What it is called in messages."""

    schema: ClassVar[Mapping[str, Any]] = {"type": ["number", "string", "boolean", "array"]}
    """How it is written, for editors."""

    @classmethod
    def from_item(cls, item: Item, name: str) -> Variation:
        """Read a value, a list of values, or two ends with dots between them.

        Raises:
            UserError: it is none of these.
        """
        if isinstance(item.value, list):
            if not item.value:
                raise UserError(f"{name!r} has no values", item.place, "a value, or a list of them", "wrong-length")
            return cls(tuple(item.value))
        if isinstance(item.value, str) and BETWEEN in item.value:
            low, _, high = item.value.partition(BETWEEN)
            if not (low.strip() and high.strip()) or BETWEEN in high:
                hint = f"two ends, as 0.5 {BETWEEN} 1.2 or 35 cm {BETWEEN} 45 cm"
                raise UserError(f"{name!r} cannot be drawn from {item.value!r}", item.place, hint, "wrong-type")
            return cls(ends=(_number(low, item), _number(high, item)))
        return cls((item,))

    def factor(self, name: str, spec: Param) -> Factor:
        """Return it for what is declared.

        Args:
            name: what it is for, as a column of the results.
            spec: type, unit and bounds of its values.

        Raises:
            UserError: with every value that is none of those.
        """
        if self.ends:
            low, high = _converted(spec, self.ends)
            if not all(isinstance(end, (int, float)) for end in (low, high)):
                raise UserError(f"{name!r} is no number, and cannot be drawn", self.ends[0].place, code="wrong-type")
            if low > high:
                message = f"{name!r} runs from {low:g} down to {high:g}"
                raise UserError(message, self.ends[0].place, "give the low end first", "out-of-range")
            return Factor(name, spec.unit, ends=(low, high), whole=spec.type is int)
        values: list[Any] = []
        for value in _converted(spec, self.values):  # 1 m and 100 cm are the same, and so would be their trials
            if value not in values:
                values.append(value)
        return Factor(name, spec.unit, tuple(values))


@dataclass(frozen=True)
class Factor:
    """Something that trials are given, and may differ in.

    Attributes:
        name: as a column of the results.
        unit: SI unit of its values, "" for none.
        values: all that are tried; none if it is drawn.
        ends: between which it is drawn, None if it is not.
        whole: whether only whole numbers are drawn.
    """

    name: str
    unit: str = ""
    values: tuple[Any, ...] = ()
    ends: tuple[float, float] | None = None
    whole: bool = False

    @property
    def levels(self) -> Sequence[Any]:
        """What is tried with every seed: its values, or for one that is drawn the one fact that it is (None)."""
        return self.values or (None,)

    @property
    def varies(self) -> bool:
        """Whether trials differ in it."""
        return len(self.values) > 1 or self.ends is not None

    def value(self, level: Any, seed: int) -> Any:
        """Return what a trial gets: this level, or what its seed draws."""
        if self.ends is None:
            return level
        low, high = self.ends
        share = _share(f"{seed}/{self.name}")
        if self.whole:
            return low + math.floor(share * (high - low + 1))
        width = high - low
        drawn = low + float(share) * width
        return min(max(round(drawn, _DIGITS - Decimal(width).adjusted()), low), high)


def _share(text: str) -> Fraction:
    """Return a number from 0 to below 1 that follows from a text, the same on every machine and for ever."""
    return Fraction(int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "big"), 2**64)


def _number(text: str, item: Item) -> Item:
    """Return one end as a file would hold it."""
    text = text.strip()
    try:
        return Item(int(text), item.place)
    except ValueError:
        pass
    try:
        return Item(float(text), item.place)
    except ValueError:
        return Item(text, item.place)


def _converted(spec: Param, items: Sequence[Item]) -> list[Any]:
    values: list[Any] = []
    problems: list[Problem] = []
    for item in items:
        try:
            values.append(convert(spec, item))
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    return values
