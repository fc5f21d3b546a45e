"""Rows of declared parameters: name, type, default, meaning."""

from __future__ import annotations

import dataclasses
import types
import typing
from collections.abc import Iterable, Mapping
from typing import Any

from humanoid_bt.core.params import Param
from parts.markdown import table

Row = tuple[str, str, str, str]


def parameter_table(first: str, rows: Iterable[Row]) -> str:
    """Return a table of parameters.

    Args:
        first: what its first column holds: keys, parameters, branches.
        rows: of :func:`parameter_row`, and others like them.
    """
    return table((first, "type", "default", "meaning"), rows)


def parameter_row(spec: Param, sections: Mapping[type, str] | None = None) -> Row:
    """Return the row of a parameter.

    Args:
        spec: the parameter.
        sections: heading of the section of this page that tells of a dataclass, for parameters that hold one.
    """
    return f"`{spec.name}`", _type(spec, sections or {}), _default(spec), spec.doc.replace("|", "\\|")


def dataclass_in(kind: Any) -> type | None:
    """Return the dataclass that values of a type are or hold, None if there is none."""
    if dataclasses.is_dataclass(kind):
        return None if hasattr(kind, "from_item") else typing.cast(type, kind)
    return next((inner for arg in typing.get_args(kind) if (inner := dataclass_in(arg))), None)


def _type(spec: Param, sections: Mapping[type, str]) -> str:
    inner = dataclass_in(spec.type)
    bounds = [
        f"{sign} {value:g}"
        for sign, value in (("≥", spec.minimum), (">", spec.above), ("≤", spec.maximum))
        if value is not None
    ]
    if spec.minimum is not None and spec.minimum == spec.maximum:
        return f"{spec.minimum:g}"
    if inner is None:
        name = spec.type_name.replace("|", "\\|")
        name = name.replace("mapping of number", "mapping of names to numbers")
        return ", ".join([name.replace("mapping of list", "mapping of names to lists"), *bounds])
    heading = sections[inner]
    link = f"[{heading.lower()}](#{heading.lower().replace(' ', '-')})"
    origin = typing.get_origin(spec.type)
    if origin in (typing.Union, types.UnionType):
        origin = next((typing.get_origin(arg) for arg in typing.get_args(spec.type) if arg is not type(None)), None)
    return {list: f"list of {link}", dict: f"mapping of names to {link}"}.get(typing.cast(Any, origin), link)


def _default(spec: Param) -> str:
    if spec.required:
        return "required"
    value = spec.default
    if value is None or value == "":
        return ""
    if dataclasses.is_dataclass(value):
        return "its defaults"
    return f"`{_plain(value)}`"


def _plain(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_plain, value))}]"
    return f"{value:g}" if isinstance(value, float) else str(value)
