"""Giving nodes and skills the values of their parameters, and those of keys each time they start."""

from __future__ import annotations

import functools
import typing
from collections.abc import Callable, Mapping
from typing import Any

from humanoid_bt.core.errors import Place, nearest
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import Param, own, params_of
from humanoid_bt.core.reading import convert
from humanoid_bt.decision.blackboard import Key, names_key

_READ_AT_START = "_read_at_start"


def assign(target: Any, values: Mapping[str, Any]) -> None:
    """Set an instance's declared parameters as attributes: the values given, defaults for the rest.

    A parameter that is given a key of the blackboard gets the key's value each time the node starts.

    Raises:
        TypeError: a required parameter is missing, or a value is for none that is declared.
    """
    declared, owner = params_of(type(target)), type(target).__name__
    read_at_start: dict[str, Key] = {}
    if unknown := [name for name in values if name not in declared]:
        valid = nearest(unknown[0], declared) or "it takes none"
        raise TypeError(f"{owner} has no parameter {', '.join(map(repr, unknown))}: {valid}")
    for name, spec in declared.items():
        if name not in values and spec.required:
            raise TypeError(f"{owner} needs the parameter {name!r}")
        value = own(values.get(name, spec.default))
        if isinstance(value, str) and (reads_itself := _reads_itself(spec.type)):
            value = reads_itself.from_item(Item(value, Place(owner)), name)
        if isinstance(value, Key) and not names_key(spec.type):
            read_at_start[name] = value
            value = None if spec.required else own(spec.default)
        setattr(target, name, value)
    if read_at_start:
        vars(target)[_READ_AT_START] = read_at_start
        target.initialise = functools.partial(_start, target, declared, read_at_start, target.initialise)


def _start(target: Any, declared: Mapping[str, Param], keys: Mapping[str, Key], initialise: Callable[[], None]) -> None:
    """Give parameters the values of the keys they were given, then start the node."""
    for name, key in keys.items():
        place = Place(f"the blackboard's {key.name!r}")
        setattr(target, name, convert(declared[name], item_of(key.value, place)))
    initialise()


def keys_read(target: Any) -> dict[str, Key]:
    """Return the parameters of an instance that are read from the blackboard each time it starts."""
    found: dict[str, Key] = vars(target).get(_READ_AT_START, {})
    return found


def _reads_itself(kind: Any) -> Any:
    """Return the type among those of a parameter that reads itself from text, None if there is none."""
    return next((inner for inner in (kind, *typing.get_args(kind)) if hasattr(inner, "from_item")), None)
