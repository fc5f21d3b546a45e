"""Values for a tree's parameters that come from outside of files: from a command line, or from Python."""

from __future__ import annotations

import difflib
import textwrap
from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace
from os import PathLike
from typing import Any

from humanoid_bt.core.errors import Place, Problem, UserError, nearest
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import Param, PerceptName
from humanoid_bt.core.reading import convert
from humanoid_bt.core.units import base_unit
from humanoid_bt.files import document
from humanoid_bt.tree.source.parameters import Argument, Declaration, NodeItem

TEXTS = (str, PerceptName)
"""Types of parameters that take what is given from outside as it is written: 12 and yes are texts."""

_SHOWN = 60  # characters of a value, in messages


def given(parameters: Mapping[str, Any] | None, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of parameters that were given in a mapping and as keyword arguments.

    Raises:
        UserError: one is given in both, or what should be a mapping is none.
    """
    if parameters is None:
        return dict(values)
    if not isinstance(parameters, Mapping) or not all(isinstance(name, str) for name in parameters):
        message = f"'parameters' must be a mapping of names to values, not {parameters!r}"
        raise UserError(message, code="wrong-type")
    if both := [name for name in parameters if name in values]:
        message = f"the parameter {both[0]!r} is given twice"
        raise UserError(message, hint="by itself, or in 'parameters'", code="exclusive-keys")
    return {**parameters, **values}


def overrides(
    declared: Mapping[str, Declaration],
    values: Mapping[str, Any],
    problems: list[Problem],
    arguments: Collection[str] = (),
) -> dict[str, Argument]:
    """Return the parameters that were given from outside.

    Args:
        declared: what the tree declares.
        values: plain values, text as after ``--set``, or values of a file with their places, by name.
        problems: takes every mistake.
        arguments: what else could have been given beside the parameters.
    """
    found: dict[str, Argument] = {}
    for name, value in values.items():
        place = value.place if isinstance(value, Item) else Place(textwrap.shorten(f"{name}={value}", _SHOWN))
        if name not in declared:
            hint = _meant(name, declared, arguments)
            problems.append(Problem(f"the tree has no parameter {name!r}", place, hint, "unknown-parameter"))
            continue
        spec = declared[name].spec
        if spec.type is NodeItem:
            hint = "only a tree that uses this one can give it"
            problems.append(Problem(f"the parameter {name!r} is a node", place, hint, "wrong-type"))
            continue
        try:
            item = written_item(spec, value, place)
            taken = with_unit_of([item], spec)
            unit = "" if spec.unit else taken.unit
            found[name] = Argument(convert(taken, item), place, written=item.plain(), unit=unit)
        except UserError as error:
            problems += error.problems
    return found


def _meant(name: str, declared: Collection[str], arguments: Collection[str]) -> str:
    """Return a hint: what a name that is no parameter's most likely means."""
    close = difflib.get_close_matches(name, [*declared, *arguments], n=1)
    if close and close[0] in arguments:
        return f"did you mean the argument {close[0]!r}?"
    return nearest(name, declared) or "the tree declares no parameters"


def with_unit_of(values: Iterable[Item], spec: Param) -> Param:
    """Return the declaration of a plain number with the first unit that its values have (200 ms), others unchanged."""
    if spec.type is not float or spec.unit:
        return spec
    units = (base_unit(item.value) for item in values if isinstance(item.value, str))
    return replace(spec, unit=next(filter(None, units), ""))


def written_item(spec: Param, value: Any, place: Place) -> Item:
    """Return a value that was given from outside, text read as YAML; one of a file is that already.

    Raises:
        UserError: no file could hold the value.
    """
    if isinstance(value, Item):
        return value
    return _written(spec, value, place) if isinstance(value, str) else plain_item(spec.name, value, place)


def plain_item(name: str, value: Any, place: Place) -> Item:
    """Return a plain Python value as a file would hold it.

    Args:
        name: of what it is given for.
        value: a number, text, a boolean, or a list or mapping of them; numpy's are taken too, and paths as text.
        place: where it is given.

    Raises:
        UserError: no file could hold the value.
    """
    return item_of(_plain(name, value, place), place)


def _plain(name: str, value: Any, place: Place) -> Any:
    if hasattr(value, "tolist"):  # numpy's numbers and arrays
        value = value.tolist()
    if isinstance(value, Mapping):
        return {key: _plain(str(key), part, place) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(name, part, place) for part in value]
    if value is None or isinstance(value, (bool, int, float, str, PathLike)):
        return value
    hint = "a number, text, a boolean, or a list or mapping of them"
    raise UserError(f"{name!r} cannot be {value!r}", place, f"valid: {hint}", "wrong-type")


def _written(spec: Param, text: str, place: Place) -> Item:
    if spec.type in TEXTS:
        return Item(text, place)
    try:
        return item_of(document.parse(text, str(place)).plain(), place)
    except UserError:
        return Item(text, place)
