"""The blackboard: keys that nodes of one tree share.

There is no global store. A tree file names its keys; whoever uses a key holds the :class:`Key` itself. Sub-trees
have keys of their own, but for those that their caller hands to them.
"""

from __future__ import annotations

import re
import typing
from collections.abc import Callable
from enum import Enum
from typing import Any, ClassVar

import numpy as np

from humanoid_bt.core.errors import HumanoidBtError, Place, UserError
from humanoid_bt.core.items import Item, item_of
from humanoid_bt.core.params import Param, own
from humanoid_bt.core.reading import convert, is_finite

KEY_NAME = re.compile(r"^[A-Za-z_]\w*$")
"""How keys and parameters of trees are called."""

_NOWHERE = Place("")


class _Nothing(Enum):
    """The value of a key that has none; a copy of it is itself."""

    UNSET = 0


_UNSET: Any = _Nothing.UNSET


class KeyNotSet(HumanoidBtError):  # noqa: N818 (the name says it)
    """A key was read before anything had written it."""


class Key:
    """A value that nodes share.

    As the type of a node's parameter it says that the node writes the key which the parameter names:

        found: Key = param(doc="Key that gets the place.")
        ...
        self.found.set("kitchen")

    Any other parameter of a skill may be given the value of a key: ``walk_to: {x: $x}`` in a tree file,
    ``WalkTo(x=Key("x"), ...)`` in Python. It is read each time the skill starts.

    Args:
        name: how trees call it.
        initial: its value when its tree starts; none if not given.

    Attributes:
        spec: how the tree's file declares it, None if it does not.
    """

    __slots__ = ("_value", "initial", "name", "spec")
    described: ClassVar[str] = "key"

    def __init__(self, name: str, initial: Any = _UNSET) -> None:
        self.name = name
        self.initial = initial
        self.spec: Param | None = None
        self.reset()

    @property
    def is_set(self) -> bool:
        """Whether it has a value."""
        return self._value is not _UNSET

    @property
    def has_initial(self) -> bool:
        """Whether it has a value when its tree starts."""
        return self.initial is not _UNSET

    @property
    def value(self) -> Any:
        """Its value.

        Raises:
            KeyNotSet: it has none.
        """
        if self._value is _UNSET:
            raise KeyNotSet(f"the blackboard's {self.name!r} is read before anything has written it")
        return self._value

    def set(self, value: Any) -> None:
        """Give it a value, seen by every node that is ticked after this one.

        Args:
            value: it; of a list, mapping or array the key gets a copy. A key that is declared takes what a file could
                write for it, and numbers of numpy.

        Raises:
            ValueError: it does not go with the key's declaration, or is a number that is not finite.
        """
        self._value = self.checked(value)

    def put(self, value: Any) -> None:
        """Give it a value as it is: one that was checked or that it had before, or none of a list's parts."""
        self._value = value

    def clear(self) -> None:
        """Take its value away."""
        self._value = _UNSET

    def begin_unset(self) -> None:
        """Take its value away, and that with which its tree starts."""
        self._value = self.initial = _UNSET

    def reset(self) -> None:
        """Give it its initial value, or none."""
        self._value = own(self.initial)

    def checked(self, value: Any) -> Any:
        """Return a value as the key takes it; raises as :meth:`set`."""
        try:
            return self.taken(value, _NOWHERE)
        except UserError as error:
            raise ValueError(f"the key {error.problems[0].message}") from error

    def taken(self, value: Any, place: Place) -> Any:
        """Return a value that is written somewhere as the key takes it.

        Args:
            value: it.
            place: where it is written.

        Raises:
            UserError: it does not go with the key's declaration, or is a number that is not finite.
        """
        if isinstance(value, np.generic) or (self.spec is not None and isinstance(value, np.ndarray)):
            value = value.tolist()
        if self.spec is not None:
            return convert(self.spec, item_of(value, place))
        if isinstance(value, (int, float)) and not is_finite(value):
            raise UserError(f"{self.name!r} must be finite, not {value}", place, code="out-of-range")
        return value.copy() if isinstance(value, np.ndarray) else own(value)

    def __str__(self) -> str:
        return self.name

    def __repr__(self) -> str:
        return f"Key({self.name!r})"

    @classmethod
    def from_item(cls, item: Item, parameter: str) -> Key:
        """Return the key that a YAML value names.

        Raises:
            UserError: it is no name of a key.
        """
        if not isinstance(item.value, str) or not KEY_NAME.match(item.value):
            what = f"{item.kind} {item.value!r}" if isinstance(item.value, str) else item.kind
            hint = "letters, digits and _, not beginning with a digit"
            message = f"{parameter!r} must name a key of the blackboard, not {what}"
            raise UserError(message, item.place, hint, "bad-name")
        return cls(item.value)


def are_keys(value: Any) -> bool:
    """Return whether a parameter's value is a list of keys, or a mapping to some."""
    return not isinstance(value, Key) and bool(keys_in(value))


def keys_in(value: Any) -> list[Key]:
    """Return the keys that a parameter's value is: one, a list of some, or a mapping to some."""
    parts = [value] if isinstance(value, Key) else list(value.values()) if isinstance(value, dict) else value
    return parts if isinstance(parts, list) and all(isinstance(part, Key) for part in parts) else []


def exchanged(keys: Any, of: Callable[[Key], Key]) -> Any:
    """Return a list of keys, or a mapping to some, with others in their places."""
    return {name: of(key) for name, key in keys.items()} if isinstance(keys, dict) else [of(key) for key in keys]


def names_key(kind: Any) -> bool:
    """Return whether a parameter of this type names a key, which the node writes."""
    return kind is Key or Key in typing.get_args(kind)
