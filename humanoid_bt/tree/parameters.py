"""A tree's parameters: declared in its file, overridden with ``--set``, used as ``$name``."""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal

from humanoid_bt import document
from humanoid_bt.document import Item
from humanoid_bt.errors import Place, Problem, UserError, nearest
from humanoid_bt.params import UNITS, Param, PerceptName, base_unit, is_number_text, item_of, param, read

TYPES: dict[str, Any] = {
    "number": float,
    "integer": int,
    "text": str,
    "boolean": bool,
    "percept": PerceptName,
}
"""Types that a parameter of a tree can declare."""

_NAME = re.compile(r"^[A-Za-z_]\w*$")


@dataclass(frozen=True)
class LongForm:
    """A parameter's declaration written in full."""

    type: Literal["number", "integer", "text", "boolean", "percept"] | None = param(
        None, doc="Its type; the default's if not given."
    )
    unit: str = param("", doc=f"SI unit of a number: {', '.join(UNITS)}.")
    default: Any = param(None, doc="Its value unless --set gives another.")
    doc: str = param("", doc="One line for people.")


@dataclass(frozen=True)
class Parameter:
    """One parameter of a tree and its value.

    Attributes:
        spec: its declaration.
        place: where it is declared.
        value: its value, None if it has none.
        known: whether it has a value.
        override: the ``--set`` that gave the value, if one did.
    """

    spec: Param
    place: Place
    value: Any = None
    known: bool = False
    override: Place | None = None


class Parameters:
    """The parameters of one tree file.

    Args:
        item: the mapping under ``parameters``, None if there is none.
        overrides: name to text, from ``--set name=value``.
        problems: takes every mistake.
    """

    def __init__(self, item: Item | None, overrides: Mapping[str, str], problems: list[Problem]) -> None:
        self._problems = problems
        self._used: set[str] = set()
        self._origins: dict[Place, str] = {}
        self._known: dict[str, Parameter] = {}
        if item is not None and not isinstance(item.value, dict) and item.value is not None:
            problems.append(Problem(f"the parameters must be a mapping, not {item.kind}", item.place, "name: default"))
        elif item is not None and item.value is not None:
            for name, value in item.value.items():
                self._declare(name, value, item.key_places[name], overrides)
        for name in overrides:
            if name not in self._known:
                hint = nearest(name, self._known) or "the tree declares no parameters"
                problems.append(Problem(f"the tree has no parameter {name!r}", _set_place(name, overrides), hint))

    @property
    def values(self) -> dict[str, Any]:
        """Every parameter's value."""
        return {name: parameter.value for name, parameter in self._known.items() if parameter.known}

    def used(self, item: Item) -> Parameter | None:
        """Return the parameter that a value refers to (``$name``) and mark it used; None if it is no reference.

        Raises:
            UserError: there is no such parameter.
        """
        if not isinstance(item.value, str) or not item.value.startswith("$"):
            return None
        name = item.value[1:]
        if name not in self._known:
            self._used.update(difflib.get_close_matches(name, self._known, n=1))  # one mistake, not two
            hint = nearest(name, self._known) or "the tree declares no parameters"
            raise UserError(f"unknown parameter {item.value!r}", item.place, hint)
        self._used.add(name)
        return self._known[name]

    def resolve(self, item: Item) -> Item | None:
        """Return a value with every ``$name`` in it replaced; None if one of them has no value.

        Raises:
            UserError: there is no such parameter.
        """
        if isinstance(item.value, list):
            children = [self.resolve(child) for child in item.value]
            known = [child for child in children if child is not None]
            return Item(known, item.place) if len(known) == len(children) else None
        if isinstance(item.value, dict):
            pairs = {key: self.resolve(child) for key, child in item.value.items()}
            found = {key: child for key, child in pairs.items() if child is not None}
            return Item(found, item.place, item.key_places) if len(found) == len(pairs) else None
        parameter = self.used(item)
        if parameter is None:
            return item
        if not parameter.known:
            return None
        if parameter.override:
            place, origin = parameter.override, f"{item.value} is used at {item.place}"
        else:
            place, origin = item.place, f"{item.value} is declared at {parameter.place}"
        self._origins[place] = origin
        return item_of(parameter.value, place)

    def skim(self, item: Item) -> None:
        """Mark what an item that cannot be read refers to as used: that is one mistake, not two."""
        if isinstance(item.value, str) and item.value[1:] in self._known:
            self._used.add(item.value[1:])
        children = item.value.values() if isinstance(item.value, dict) else item.value
        for child in children if isinstance(item.value, (dict, list)) else ():
            self.skim(child)

    def explain(self, problem: Problem) -> Problem:
        """Return a problem with a word on the parameter that the value came from, if it came from one."""
        origin = self._origins.get(problem.place) if problem.place else None
        if origin is None:
            return problem
        return Problem(
            problem.message, problem.place, "; ".join(part for part in (problem.hint.rstrip("."), origin) if part)
        )

    def report_unused(self) -> None:
        """Note a problem for every parameter that no node uses."""
        for name, parameter in self._known.items():
            if name not in self._used:
                hint = f"use it as ${name}, or remove it"
                self._problems.append(Problem(f"the parameter {name!r} is not used", parameter.place, hint))

    def _declare(self, name: str, item: Item, place: Place, overrides: Mapping[str, str]) -> None:
        if not _NAME.match(name):
            hint = "letters, digits and _, not beginning with a digit"
            self._problems.append(Problem(f"{name!r} cannot be a parameter's name", place, hint))
        try:
            spec, default = _declaration(name, item)
            self._known[name] = Parameter(spec, place)  # so that its uses are no mistakes if its value is one
            if name in overrides:
                override = _set_place(name, overrides)
                if spec.type is float and not spec.unit:
                    spec = replace(spec, unit=base_unit(overrides[name]) or "")
                value = spec.convert(_override(spec, overrides[name], override))
                self._known[name] = Parameter(spec, place, value, True, override)
            elif default is not None:
                self._known[name] = Parameter(spec, place, spec.convert(default), True)
            else:
                hint = f"give it one: --set {name}=..., or a default"
                self._problems.append(Problem(f"the parameter {name!r} has no value", place, hint))
        except UserError as error:
            self._problems += error.problems
            self._known.setdefault(name, Parameter(Param(name, Any), place))


def _declaration(name: str, item: Item) -> tuple[Param, Item | None]:
    if not isinstance(item.value, dict):
        return _inferred(name, item), item if item.value is not None else None
    form: LongForm = read(LongForm, item, f"the parameter {name!r}")
    default = item.value.get("default")
    if default is not None and default.value is None:
        default = None
    if form.unit and form.unit not in UNITS:
        raise UserError(f"unknown unit {form.unit!r}", item.value["unit"].place, nearest(form.unit, UNITS))
    if form.type is not None:
        spec = Param(name, TYPES[form.type], doc=form.doc, unit=form.unit)
    elif default is not None:
        inferred = _inferred(name, default)
        spec = Param(name, inferred.type, doc=form.doc, unit=form.unit or inferred.unit)
    elif form.unit:
        spec = Param(name, float, doc=form.doc, unit=form.unit)
    else:
        hint = f"type: one of {', '.join(TYPES)}"
        raise UserError(f"the parameter {name!r} has neither a type nor a default", item.place, hint)
    if spec.unit and spec.type not in (float, int):
        raise UserError(f"the parameter {name!r} has a unit but is no number", item.value["unit"].place)
    return spec, default


def _inferred(name: str, default: Item) -> Param:
    if isinstance(default.value, str):
        unit = base_unit(default.value)  # "45 cm" is a number with a unit
        return Param(name, float, unit=unit or "") if unit or is_number_text(default.value) else Param(name, str)
    kinds = {bool: bool, int: float, float: float}  # 1 may become 0.5 with --set
    return Param(name, kinds.get(type(default.value), Any))


def _override(spec: Param, text: str, place: Place) -> Item:
    if spec.type in (str, PerceptName):
        return Item(text, place)
    try:
        return item_of(document.parse(text, str(place)).plain(), place)
    except UserError:
        return Item(text, place)


def _set_place(name: str, overrides: Mapping[str, str]) -> Place:
    return Place(f"--set {name}={overrides[name]}")
