"""How percept sources are named in scenes, trees and arguments: by name, each with its parameters."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple

from humanoid_bt.core.errors import Place, Problem, UserError
from humanoid_bt.core.items import Item

_HINT = "perception: NAME, or perception: [NAME, {NAME: {PARAMETER: VALUE}}]"
_NAME: dict[str, Any] = {"type": "string", "minLength": 1}
_NAMES: dict[str, Any] = {
    "type": "object",
    "additionalProperties": {"type": ["object", "null"]},
    "minProperties": 1,
}


class NamedSource(NamedTuple):
    """One source as it is written.

    Attributes:
        name: of the source.
        values: its parameters, a mapping.
        place: where the name stands.
    """

    name: str
    values: Item
    place: Place


class Sources:
    """Percept sources as they are written.

    Args:
        every: each of them, in order.
        written: the same as plain YAML.
        place: where they begin.
    """

    described: ClassVar[str] = "names of sources, each with its parameters"
    """What they are called in messages."""

    schema: ClassVar[Mapping[str, Any]] = {
        "anyOf": [_NAME, _NAMES, {"type": "array", "items": {"anyOf": [_NAME, _NAMES]}, "minItems": 1}]
    }
    """How they are written, for editors."""

    def __init__(self, every: tuple[NamedSource, ...], written: Any, place: Place) -> None:
        self.every, self.written, self.place = every, written, place

    @classmethod
    def from_item(cls, item: Item, _name: str = "") -> Sources:
        """Read them.

        Raises:
            UserError: this names none.
        """
        problems: list[Problem] = []
        found = tuple(_named(item, problems))
        if not found and not problems:
            problems.append(Problem("'perception' names no source", item.place, _HINT, "wrong-type"))
        if problems:
            raise UserError(problems)
        return cls(found, item.plain(), item.place)

    @property
    def texts(self) -> list[str]:
        """Each of them as the command line takes it: its name, or with parameters."""
        plain = [(one.name, one.values.plain()) for one in self.every]
        return [json.dumps({name: values}, ensure_ascii=False) if values else name for name, values in plain]


def _named(item: Item, problems: list[Problem]) -> Iterator[NamedSource]:
    if isinstance(item.value, list):
        for part in item.value:
            if isinstance(part.value, list):
                problems.append(_wrong(part))
            else:
                yield from _named(part, problems)
    elif isinstance(item.value, str) and item.value.strip():
        yield NamedSource(item.value, Item({}, item.place), item.place)
    elif isinstance(item.value, dict):
        for key, values in item.value.items():
            name, place = str(key), item.key_places.get(key, item.place)  # from Python, a key may be anything
            if values.value is None:
                yield NamedSource(name, Item({}, place), place)
            elif isinstance(values.value, dict):
                texts = {str(parameter): value for parameter, value in values.value.items()}
                yield NamedSource(name, Item(texts, values.place, values.key_places), place)
            else:
                message = f"the parameters of the source {name!r} must be a mapping, not {values.kind}"
                problems.append(Problem(message, values.place, f"{name}: {{PARAMETER: VALUE}}", "wrong-type"))
    else:
        problems.append(_wrong(item))


def _wrong(item: Item) -> Problem:
    return Problem(f"a percept source must be named, and this is {item.kind}", item.place, _HINT, "wrong-type")
