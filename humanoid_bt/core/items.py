"""Values with the place where they were written, so that a mistake can be shown where it is."""

from __future__ import annotations

import os
from dataclasses import dataclass, field
from numbers import Number
from os import PathLike
from typing import Any

from humanoid_bt.core.errors import Place


@dataclass(frozen=True)
class Item:
    """A value of a YAML file and its place.

    Attributes:
        value: a scalar, a ``list[Item]`` or a ``dict[str, Item]``.
        place: where the value begins.
        key_places: for a mapping, where each key stands.
        text_at: for text on one line, how many columns behind its place its first character stands.
    """

    value: Any
    place: Place
    key_places: dict[str, Place] = field(default_factory=dict)
    text_at: int | None = field(default=None, compare=False)

    def place_of(self, *keys: str | int, key: bool = False) -> Place:
        """Return where a value in it is written, or what stands around it where it is not.

        Args:
            keys: those of mappings and indices of lists that lead to it.
            key: return where its key stands instead.
        """
        found, place = self, self.place
        for one in keys:
            if isinstance(found.value, dict) and one in found.value:
                written = found.key_places.get(str(one), found.place)
                found = found.value[one]
            elif isinstance(found.value, list) and isinstance(one, int):
                found = found.value[one]
                written = found.place
            else:
                break
            place = written if key else found.place
        return place

    def plain(self) -> Any:
        """Return the value as ``yaml.safe_load`` would give it."""
        if isinstance(self.value, dict):
            return {key: item.plain() for key, item in self.value.items()}
        if isinstance(self.value, list):
            return [item.plain() for item in self.value]
        return self.value

    @property
    def kind(self) -> str:
        """The value's kind in words, for messages."""
        names = {dict: "a mapping", list: "a list", str: "text", bool: "a boolean", type(None): "nothing"}
        other = "a number" if isinstance(self.value, Number) else f"an object of type {type(self.value).__name__}"
        return names.get(type(self.value), other)


def item_of(value: Any, place: Place) -> Item:
    """Wrap a plain Python value (a default, a ``--set`` argument) as an item with one place.

    A path is its text, a number of numpy is one of Python.
    """
    if isinstance(value, dict):
        return Item({key: item_of(child, place) for key, child in value.items()}, place)
    if isinstance(value, (list, tuple)):
        return Item([item_of(child, place) for child in value], place)
    if getattr(value, "shape", None) == ():  # a number of numpy, which takes too long to import for a file alone
        value = value.item()
    return Item(os.fspath(value) if isinstance(value, PathLike) else value, place)
