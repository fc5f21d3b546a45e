"""What is wrong with declared parameters themselves, before any value is given."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterator, Mapping
from typing import Any

from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.items import item_of
from humanoid_bt.core.params import Param, params_of
from humanoid_bt.core.reading import convert

_PLAIN = (float, int, str, bool)
_VALID = "valid: float, int, str, bool, Literal[...], list[...], tuple[...], X | None, PerceptName, and Key in skills"


def is_readable(kind: Any) -> bool:
    """Return whether a file can give a value of a type."""
    origin, args = typing.get_origin(kind), typing.get_args(kind)
    if origin in (list, tuple, dict, typing.Union, types.UnionType):
        return all(is_readable(arg) for arg in args if arg not in (Ellipsis, types.NoneType))
    if kind is Any or origin is typing.Literal or hasattr(kind, "from_item"):
        return True
    if isinstance(kind, type) and dataclasses.is_dataclass(kind):
        return bool(params_of(kind))
    return getattr(kind, "__supertype__", kind) in _PLAIN


def wrong_parameters(name: str, declared: Mapping[str, Param], place: Place, code: str) -> Iterator[Problem]:
    """Yield what is wrong with types and defaults.

    Args:
        name: of what declares them.
        declared: them, by name.
        place: where that is declared.
        code: of the findings.
    """
    for parameter, spec in declared.items():
        if not is_readable(spec.type):
            message = f"the parameter {parameter!r} of {name!r} cannot be {_named(spec.type)}"
            yield Problem(message, place, _VALID, code)
        elif not spec.required and spec.default is not None and not dataclasses.is_dataclass(spec.default):
            yield from _wrong_default(name, spec, place, code)


def _wrong_default(name: str, spec: Param, place: Place, code: str) -> Iterator[Problem]:
    """Yield why a default is no value of its parameter; what is written as text with a unit is none in Python."""
    try:
        value = convert(spec, item_of(spec.default, place))
    except UserError as error:
        for problem in error.problems:
            yield Problem(f"in {name!r}, the default of {problem.message}", place, problem.hint, code)
        return
    if isinstance(value, _PLAIN) and value != spec.default:
        message = f"in {name!r}, the default of {spec.name!r} must be {value!r}, not {spec.default!r}"
        yield Problem(message, place, f"in {spec.unit or 'plain numbers'}: no unit is read in Python", code)


def _named(kind: Any) -> str:
    return kind.__qualname__ if isinstance(kind, type) else str(kind).removeprefix("typing.")
