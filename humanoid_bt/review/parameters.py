"""The parameters of a run out of its recording, as a file that the next run takes, and how two sets of them differ."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.items import Item
from humanoid_bt.core.texts import one_line
from humanoid_bt.core.units import quantity, spaced
from humanoid_bt.files import document
from humanoid_bt.record.parts import MAGIC
from humanoid_bt.review import setup, staged
from humanoid_bt.review.recording import Recording, open_recording
from humanoid_bt.review.setup import ParameterInfo

_NOISE = 1e-9  # relative; a unit's factor leaves as much in a number
_HUGE = 1e15  # from here on a float has an exponent


@dataclass(frozen=True)
class ParameterChange:
    """A parameter of which two runs have different values.

    Attributes:
        name: its name.
        before, after: its values and where they are from; None where there is none of this name.
    """

    name: str
    before: ParameterInfo | None
    after: ParameterInfo | None


def is_recording(path: Path) -> bool:
    """Return whether a file is a recording, or at least is called so."""
    if path.suffix == ".rrd":
        return True
    try:
        if not path.is_file():  # a pipe would wait for somebody who writes
            return False
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except (OSError, ValueError):
        return False


def given_parameters(path: Path) -> dict[str, Any]:
    """Return what a file of parameters, or a recording, gives a tree, by name.

    Values of a file have their places. Of a recording all come: its tree's defaults may be others today.

    Raises:
        UserError: it cannot be read, or is neither.
    """
    if is_recording(path):
        return open_recording(path).parameters
    return _items(path)


def known_parameters(path: Path) -> dict[str, ParameterInfo]:
    """Return the parameters of a recording or of a file, by name.

    Raises:
        UserError: it cannot be read, or is neither.
    """
    if is_recording(path):
        return _of_recording(open_recording(path))
    return {
        name: ParameterInfo(_in_si_units(item.plain()), item.plain(), str(item.place))
        for name, item in _items(path).items()
    }


def as_yaml(recording: Recording, again: str = "") -> str:
    """Return a file of a run's parameters, with comments that say where each value is from, and what was staged.

    Args:
        recording: of the run.
        again: command that runs it again with all that was staged, "" if none is known.
    """
    found = _of_recording(recording)
    head = [recording.title, f"{relative(recording.path)}, began {recording.setup['began'] or '?'}"]
    head += [f"staged: {line}" for line in staged.told(recording.setup)]
    head += [f"again: {again}"] if again else []
    lines = [(_line(name, parameter), parameter.origin) for name, parameter in found.items()]
    width = max((len(line) for line, _ in lines if "\n" not in line), default=0)
    body = [f"{line:<{width}}  # {one_line(origin)}" if origin else line for line, origin in lines]
    return "\n".join([*(f"# {one_line(line)}" for line in head), *(body or ["{}"])]) + "\n"


def changed_parameters(before: dict[str, ParameterInfo], after: dict[str, ParameterInfo]) -> Iterator[ParameterChange]:
    """Yield the parameters that have different values, or are only on one side."""
    for name in dict.fromkeys((*before, *after)):
        one, other = before.get(name), after.get(name)
        if one is None or other is None or not _alike(one, other):
            yield ParameterChange(name, one, other)


def _alike(one: ParameterInfo, other: ParameterInfo) -> bool:
    """Return whether two parameters are the same; a file does not say whether "5 s" is a quantity or a text."""
    return same(one.value, other.value) or same(one.value, other.written) or same(one.written, other.value)


def same(one: Any, other: Any) -> bool:
    """Return whether two plain values are the same, numbers but for the noise of their units."""
    if isinstance(one, bool) or isinstance(other, bool):
        return one is other
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return math.isclose(one, other, rel_tol=_NOISE) or (math.isnan(one) and math.isnan(other))
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    return bool(one == other)


def shown(parameter: ParameterInfo | None) -> str:
    """Return a parameter's value as people write it."""
    if parameter is None:
        return "-"
    value = as_written(parameter)
    return one_line(as_text(value if isinstance(parameter.value, str) else spaced(value)))


def as_text(value: Any) -> str:
    """Return a plain value as people write it: a text as it is, a whole number without a point."""
    return value if isinstance(value, str) else json.dumps(_whole(value))


def _whole(value: Any) -> Any:
    """Return a plain value with integers in the place of floats that are whole."""
    if isinstance(value, list):
        return [_whole(part) for part in value]
    if isinstance(value, dict):
        return {key: _whole(part) for key, part in value.items()}
    return int(value) if isinstance(value, float) and value.is_integer() and abs(value) < _HUGE else value


def as_written(parameter: ParameterInfo) -> Any:
    """Return a value as it was written, with its unit, if that says the same: in a tree's file ``$$`` stands for $."""
    if parameter.written is not None and same(_in_si_units(parameter.written), parameter.value):
        return parameter.written
    return parameter.value


def _of_recording(recording: Recording) -> dict[str, ParameterInfo]:
    return setup.parameters(recording.setup["tree"])


def _items(path: Path) -> dict[str, Item]:
    """Return the values of a file of parameters, with their places.

    Raises:
        UserError: it cannot be read, or holds no mapping.
    """
    item = document.load(path)
    if not isinstance(item.value, dict):
        hint = "a mapping: 'name: value', one a line; humanoid-bt params RECORDING writes one"
        raise UserError(f"a file of parameters is a mapping, not {item.kind}", item.place, hint, "wrong-type")
    return item.value


def _line(name: str, parameter: ParameterInfo) -> str:
    """Return a parameter as YAML, on one line."""
    return f"{document.as_line(name)}: {document.as_line(as_written(parameter))}"


def _in_si_units(value: Any) -> Any:
    """Return a written value as a plain one in SI units: 0.45 for "45 cm"."""
    if isinstance(value, list):
        return [_in_si_units(part) for part in value]
    found = quantity(value) if isinstance(value, str) else None
    return found[0] if found else value
