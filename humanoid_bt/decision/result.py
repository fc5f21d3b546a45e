"""Declared results: what a skill reached or found out, by name and with its unit.

A skill declares a result as it declares a parameter, and sets it by plain assignment:

    class Reach(Skill):
        hand_error: float = result(unit="m", doc="From the palm to the target.")

        def update(self) -> Status:
            self.hand_error = math.dist(palm, target)

It is forgotten when the skill starts anew; what is not set is no result.
"""

from __future__ import annotations

import functools
import math
import numbers
import typing
from collections.abc import Mapping
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from humanoid_bt.core.params import type_name
from humanoid_bt.core.reading import is_finite, with_article
from humanoid_bt.core.units import base_unit, readable

ResultValue = float | int | bool | str

_declared: WeakKeyDictionary[type, Mapping[str, Result]] = WeakKeyDictionary()

_TAKES: dict[Any, Any] = {
    float: numbers.Real,
    int: numbers.Integral,
    bool: (bool, np.bool_),
    str: str,
}  # what a result can be declared to be -> what can be assigned to it


class Reported(NamedTuple):
    """A result as a skill has set it: name, value, and SI unit of a number, "" for none."""

    name: str
    value: ResultValue
    unit: str

    def __str__(self) -> str:
        return f"{self.name.replace('_', ' ')} {readable(self.value, self.unit)}"


class Result:
    """A declared result: the attribute of a skill's class, through which its instances set theirs.

    Attributes:
        name: as the attribute is called.
        unit: SI unit of a number, "" for none.
        doc: one line.
    """

    def __init__(self, unit: str, doc: str) -> None:
        self.name, self.unit, self.doc = "", unit, doc
        self._owner: type = object

    def __set_name__(self, owner: type, name: str) -> None:
        self._owner, self.name = owner, name

    def __get__(self, skill: Any, owner: type | None = None) -> Any:
        if skill is None:
            return self
        try:
            return skill._results[self.name]
        except KeyError:
            raise AttributeError(f"the result {self.name!r} is not set yet", name=self.name, obj=skill) from None

    def __set__(self, skill: Any, value: Any) -> None:
        if type(value) is not float or self.type is not float or not math.isfinite(value):  # most are, in every tick
            value = self._checked(value)
        skill._results[self.name] = value

    def __delete__(self, skill: Any) -> None:
        skill._results.pop(self.name, None)

    @functools.cached_property
    def type(self) -> Any:
        """Its Python type, as annotated.

        Raises:
            TypeError: it is annotated with none of the types that a result can have, or not at all.
        """
        kind = typing.get_type_hints(self._owner).get(self.name)
        if kind not in _TAKES:
            names = ", ".join(known.__name__ for known in _TAKES)
            what = "is not annotated" if kind is None else f"cannot be {type_name(kind)}"
            raise TypeError(f"the result {self.name!r} {what}; valid: {names}")
        return kind

    @property
    def type_name(self) -> str:
        """The type as people read it: ``number [m]``."""
        return type_name(self.type) + (f" [{self.unit}]" if self.unit else "")

    def _checked(self, value: Any) -> ResultValue:
        kind = self.type
        if not isinstance(value, _TAKES[kind]) or (isinstance(value, bool) and kind is not bool):
            raise TypeError(f"the result {self.name!r} must be {with_article(type_name(kind))}, not {value!r}")
        converted: ResultValue = kind(value)
        if isinstance(converted, (int, float)) and not is_finite(converted):
            raise ValueError(f"the result {self.name!r} must be finite, not {converted}")
        return converted


def result(*, doc: str, unit: str = "") -> Any:
    """Declare a result of a skill: an annotated attribute of its class.

    Args:
        doc: one line.
        unit: SI unit of a number.

    Raises:
        ValueError: the unit is none of SI's.
    """
    if (si_unit := base_unit(f"1 {unit}")) not in (None, unit):
        raise ValueError(f"a result is in SI units: unit={si_unit!r}, not {unit!r}")
    return Result(unit, doc)


def declared_results(cls: type) -> Mapping[str, Result]:
    """Return the results that a class declares, inherited ones first."""
    found = _declared.get(cls)
    if found is None:
        named = {name: value for base in reversed(cls.__mro__) for name, value in vars(base).items()}
        found = _declared[cls] = {name: value for name, value in named.items() if isinstance(value, Result)}
    return found


def results_of(node: Any) -> dict[str, ResultValue]:
    """Return what a node has set since it started, by name; only skills set something."""
    return getattr(node, "_results", {})


def reported(node: Any) -> tuple[Reported, ...]:
    """Return what a node has set since it started, with units, in the order in which it was set first."""
    cls = type(node)
    return tuple(Reported(name, value, getattr(cls, name).unit) for name, value in results_of(node).items())
