"""What a program looks up in a session by name: keys of the tree's blackboard, percepts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, MutableMapping
from typing import Any

from humanoid_bt.core.errors import HumanoidBtError, Place, UserError, nearest
from humanoid_bt.core.params import own
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.perception.track import Track


class UnknownKey(UserError, KeyError):  # noqa: N818 (the name says it)
    """There is no key or percept of this name, or the key has no value."""

    __str__ = Exception.__str__  # a KeyError's is in quotes


class Percepts(dict[str, Track]):
    """What was seen so far, by name; what was not is answered with what was."""

    def __missing__(self, name: str) -> Track:
        hint = nearest(name, self) or "nothing was seen yet"
        raise UnknownKey(f"no percept {name!r} was seen so far", hint=hint)


class Blackboard(MutableMapping[str, Any]):
    """The keys of a tree by name, those of its sub-trees left aside.

    It holds what has a value. A key that the tree does not have cannot be set, and one that its file declares takes
    what its type takes: 0.45, or text as in the file, "45 cm".

    Args:
        keys: the tree's.
        begun: whether the tree has been ticked; before it, what is set is the value that a key begins with,
            and what is deleted begins with none.
        over: whether the run has ended; nothing can be set then.
        tell: is told the name of each key that is set, and its value; only the name of one that is deleted.
    """

    def __init__(
        self, keys: Iterable[Key], begun: bool, over: bool = False, tell: Callable[..., None] | None = None
    ) -> None:
        self._keys = {key.name: key for key in keys}
        self._begun, self._over, self._tell = begun, over, tell

    def __getitem__(self, name: str) -> Any:
        key = self._key(name)
        if not key.is_set:
            hint = f"with a value: {', '.join(self) or 'none'}"
            raise UnknownKey(f"the key {name!r} has no value yet", hint=hint)
        return key.value

    def __setitem__(self, name: str, value: Any) -> None:
        key = self._open(name)
        value = key.taken(value, Place(f"the blackboard's {name!r}"))
        key.put(value)
        if not self._begun:
            key.initial = own(value)
        if self._tell is not None:
            self._tell(name, value)

    def __delitem__(self, name: str) -> None:
        key = self._open(name)
        key.clear() if self._begun else key.begin_unset()
        if self._tell is not None:
            self._tell(name)

    def __iter__(self) -> Iterator[str]:
        return (name for name, key in self._keys.items() if key.is_set)

    def __len__(self) -> int:
        return sum(key.is_set for key in self._keys.values())

    def __repr__(self) -> str:
        values = [f"{name}: {key.value!r}" if key.is_set else f"{name}: (not set)" for name, key in self._keys.items()]
        return f"{{{', '.join(values)}}}"

    def _open(self, name: str) -> Key:
        """Return a key that may be set."""
        if self._over:
            raise HumanoidBtError(f"the run has ended: the key {name!r} cannot be set any more")
        return self._key(name)

    def _key(self, name: str) -> Key:
        if name not in self._keys:
            hint = nearest(str(name), self._keys) or "the tree has no keys"
            raise UnknownKey(f"the tree has no key {name!r}", hint=hint)
        return self._keys[name]
