"""Fields of messages of ROS 2 by their names: written with values that are checked first, and read as plain data.

The types say nothing against a wrong value before it is sent, and sending one can end the process.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from humanoid_bt.core.errors import HumanoidBtError, nearest
from humanoid_bt.decision.calls import UNKNOWN
from humanoid_bt.gateway.types import interface

_BITS = re.compile(r"(u?)int(8|16|32|64)")
_SEQUENCE = re.compile(r"sequence<(?P<of>.+?)(?:, (?P<most>\d+))?>|(?P<item>.+)\[(?P<count>\d+)\]")
_LARGEST = {"float": 3.402823466e38, "double": sys.float_info.max}  # the first as messages of ROS 2 have it


class FieldMistake(HumanoidBtError):  # noqa: N818 (the name says it)
    """A field is not there, or does not take a value.

    Attributes:
        path: of the field, "" for the whole message.
        message: what is wrong.
        hint: what would be valid.
        code: of the finding.
    """

    def __init__(self, path: str, message: str, hint: str = "", code: str = "wrong-type") -> None:
        super().__init__(f"{message} ({hint})" if hint else message)
        self.path, self.message, self.hint, self.code = path, message, hint, code


def fill(message: Any, values: Mapping[str, Any], path: str = "") -> Any:
    """Write values into the fields of a message; return it.

    Args:
        message: it.
        values: by the names of fields, nested as the message is; what is UNKNOWN is left out.
        path: of the message in the one around it.

    Raises:
        FieldMistake: it has no such field, or one of another type.
    """
    types = message.get_fields_and_field_types()
    for name, value in values.items():
        below = f"{path}.{name}" if path else name
        if name not in types:
            raise _unknown(below, name, types)
        if value is not UNKNOWN:
            setattr(message, name, _held(types[name], value, getattr(message, name), below))
    return message


def type_at(kind: Any, path: str) -> str:
    """Return the type of a field of a type of messages, as ROS 2 writes it.

    Raises:
        FieldMistake: there is none, or it is a message of its own, or a list of them.
    """
    of, parts, held = kind, path.split("."), ""
    for index, part in enumerate(parts):
        if part.isdigit() and (sequence := _SEQUENCE.fullmatch(held)):
            held = sequence["of"] or sequence["item"]
        else:
            types = of.get_fields_and_field_types() if of is not None else {}
            if part not in types:
                raise _unknown(".".join(parts[: index + 1]), part, types)
            held = types[part]
        of = interface(held) if _is_message(held) else None
    if of is not None:
        raise FieldMistake(path, f"{path!r} is a message of its own, {held}", f"one of its fields: {_below(path, of)}")
    if (sequence := _SEQUENCE.fullmatch(held)) and _is_message(item := sequence["of"] or sequence["item"]):
        fields = _below(f"{path}.0", interface(item))
        raise FieldMistake(path, f"{path!r} is a list of messages, {held}", f"a field of one of them: {fields}")
    return held


def value_of(message: Any, path: str) -> Any:
    """Return a field of a message as plain data.

    Raises:
        FieldMistake: a list in it has no such item.
    """
    value = message
    for part in path.split("."):
        try:
            value = value[int(part)] if part.isdigit() else getattr(value, part)
        except (AttributeError, IndexError, TypeError):
            raise FieldMistake(path, f"there is nothing at {path!r}", code="unknown-key") from None
    return plain(value)


def plain(value: Any) -> Any:
    """Return what a field or a parameter of ROS 2 holds as plain data."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (bytes, bytearray)):
        return value[0] if len(value) == 1 else list(value)
    if isinstance(value, (bool, int, float, str)):
        return value
    return [plain(part) for part in value]


def _below(path: str, kind: Any) -> str:
    return ", ".join(f"{path}.{name}" for name in kind.get_fields_and_field_types())


def _unknown(path: str, name: str, types: Mapping[str, str]) -> FieldMistake:
    hint = nearest(name, types) or "it has none"
    return FieldMistake(path, f"there is no field {path!r}", hint, "unknown-key")


def _is_message(held: str) -> bool:
    return "/" in held and not _SEQUENCE.fullmatch(held)


def _held(kind: str, value: Any, now: Any, path: str) -> Any:
    """Return a value as a field of a type holds it."""
    if sequence := _SEQUENCE.fullmatch(kind):
        return _items(kind, sequence, value, path)
    if _is_message(kind):
        if not isinstance(value, Mapping):
            raise _wrong(path, kind, value, "a mapping of its fields")
        return fill(now, value, path)
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind == "boolean":
        fits = isinstance(value, bool)
    elif largest := _LARGEST.get(kind):
        fits = number
        if number and largest < abs(value) < math.inf:
            raise _too_large(path, kind, value)
        value = float(value) if fits else value
    elif (bits := _BITS.fullmatch(kind)) or kind in ("octet", "char"):
        signed, width = (not bits[1], int(bits[2])) if bits else (False, 8)
        low, high = (-(1 << width - 1), (1 << width - 1) - 1) if signed else (0, (1 << width) - 1)
        fits = number and (isinstance(value, int) or value.is_integer())
        if fits and not low <= value <= high:
            raise _too_large(path, kind, int(value))
        value = bytes([int(value)]) if fits and kind == "octet" else int(value) if fits else value
    else:  # a text, perhaps not longer than so many characters
        most = re.fullmatch(r"w?string<(\d+)>", kind)
        fits = isinstance(value, str) and (most is None or len(value) <= int(most[1]))
    if not fits:
        hint = f'a quantity is written as an expression: "{{{value}}}"' if isinstance(value, str) else ""
        raise _wrong(path, kind, value, hint)
    return value


def _items(kind: str, sequence: re.Match[str], value: Any, path: str) -> list[Any]:
    of, most, count = sequence["of"] or sequence["item"], sequence["most"], sequence["count"]
    if not isinstance(value, Sequence) or isinstance(value, str):
        raise _wrong(path, kind, value, "a list")
    if (most and len(value) > int(most)) or (count and len(value) != int(count)):
        raise FieldMistake(path, f"{path!r} cannot have {len(value)} values: it is of type {kind}", code="wrong-length")
    new = interface(of) if _is_message(of) else None
    parts = [(part, f"{path}.{index}") for index, part in enumerate(value) if part is not UNKNOWN]
    return [_held(of, part, new() if new else None, below) for part, below in parts]


def _too_large(path: str, kind: str, value: float) -> FieldMistake:
    return FieldMistake(path, f"{path!r} cannot be {value}: it is of type {kind}", code="out-of-range")


def _wrong(path: str, kind: str, value: Any, hint: str) -> FieldMistake:
    names = {str: "text", bool: "true or false", int: "a number", float: "a number", list: "a list", dict: "a mapping"}
    shown = f"text {value!r}" if isinstance(value, str) and value else names.get(type(value), repr(value))
    return FieldMistake(path, f"{path!r} cannot be {shown}: it is of type {kind}", hint)
