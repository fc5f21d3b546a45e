"""A node as its file describes it, before it is made."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from humanoid_bt.core.errors import Place
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.expressions.holding import expressions_of
from humanoid_bt.tree.node_type import NodeType


@dataclass
class Draft:
    """A node before it is made.

    Attributes:
        type: its type.
        place: where it is written.
        name: its name.
        word: its type as its file says it, which may be another name of it (``fallback``).
        values: its parameters, converted; those with a mistake are missing.
        written: those that are written in another unit than the SI's, as they are written ("60 deg").
        value_places: where each given parameter's value is written.
        given_places: where those that a sub-tree's caller gave (``$name``) are written there.
        references: parameter -> name of what it was given as ``$name``.
        unresolved: its name, and parameters, that hold a ``$name`` in another way, as they are written.
        arguments: of a sub-tree: the nodes it is given, as plain YAML, or the nodes themselves if made in Python.
        children: its children.
        branches: other sub-trees by key (a watchdog's ``on_stale``, an ``if``'s ``then``).
        keys: of a sub-tree: the keys that begin anew with it.
        taken: of a sub-tree: what its parameters are in it that were given a key, and that key of the caller.
        sound: whether it can be made: no mistake in it, its children left aside.
    """

    type: NodeType
    place: Place
    name: str
    values: dict[str, Any] = field(default_factory=dict)
    written: dict[str, Any] = field(default_factory=dict)
    value_places: dict[str, Place] = field(default_factory=dict)
    given_places: dict[str, Place] = field(default_factory=dict)
    references: dict[str, str] = field(default_factory=dict)
    unresolved: dict[str, Any] = field(default_factory=dict)
    arguments: dict[str, Any] = field(default_factory=dict)
    children: list[Draft] = field(default_factory=list)
    branches: dict[str, Draft | dict[str, Draft]] = field(default_factory=dict)
    keys: list[Key] = field(default_factory=list)
    taken: dict[Key, Key] = field(default_factory=dict)
    sound: bool = True
    word: str = ""

    def __post_init__(self) -> None:
        self.word = self.word or self.type.type_name

    def below(self) -> Iterator[tuple[str, Draft]]:
        """Return every sub-tree with the key it stands under, "" for children: ``then``, ``cases left``."""
        yield from (("", child) for child in self.children)
        for key, branch in self.branches.items():
            if isinstance(branch, Mapping):
                yield from ((f"{key} {name}", child) for name, child in branch.items())
            else:
                yield key, branch

    def called(self, child: Draft) -> str:
        """Return what a child is called in messages, as in its path: ``'walk'``, its sibling ``'walk#2'``."""
        alike = [other for other in self.children if other.name == child.name]
        number = next((number for number, other in enumerate(alike, 1) if other is child), 1)
        return repr(child.name if number == 1 else f"{child.name}#{number}")

    def begin_anew(self) -> None:
        """Forget what nodes that were made of it and ran have left in it and below: keys, and what held."""
        for draft in self.iterate():
            for key in draft.keys:
                key.reset()
            for value in draft.values.values():
                for expression in expressions_of(value):
                    expression.forget()

    def iterate(self) -> Iterator[Draft]:
        """Return this draft and all below it, parents first."""
        yield self
        for _, child in self.below():
            yield from child.iterate()
