"""What has changed since the last tick and is no event by itself: keys, percepts, what cannot be seen, stops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

from humanoid_bt.core.messages import Percept
from humanoid_bt.core.plain import plain
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.session.engine import Engine
from humanoid_bt.tree.nodes.subtree import SubTree
from humanoid_bt.tree.tree import Tree


class Changes:
    """Finds what is new since it was asked last.

    Args:
        engine: what the tree runs on.
    """

    def __init__(self, engine: Engine) -> None:
        self._engine = engine
        self._tree: Tree | None = None
        self._keys: list[tuple[str, Key]] = []
        self._set: dict[str, Any] = {}  # the keys that have a value, with it
        self._percepts: dict[str, Percept] = {}
        self._unseen: dict[str, str] = {}
        self._stops = self._inputs = 0

    def since(self, tree: Tree) -> Iterator[tuple[str, Any]]:
        """Yield kind and value of every change, as data for JSON.

        Args:
            tree: the one that runs now.
        """
        if tree is not self._tree:
            self._tree, self._keys = tree, list(_all_keys(tree))
        before, self._set = self._set, {name: plain(key.value) for name, key in self._keys if key.is_set}
        for name in before | self._set:  # an edited tree may lack what the one before it had
            if name not in self._set:
                yield "key", [name]
            elif name not in before or before[name] != self._set[name]:
                yield "key", [name, self._set[name]]
        if self._engine.unseen != self._unseen:
            self._unseen = dict(self._engine.unseen)
            yield "unseen", self._unseen
        for given in self._engine.inputs.since(self._inputs):
            yield "input", list(given)
        self._inputs = self._engine.inputs.total
        for stop in self._engine.supervisor.stops.since(self._stops):
            yield "stop", plain(asdict(stop))
        self._stops = self._engine.supervisor.stops.total

    def percepts(self, percepts: Mapping[str, Percept]) -> list[Percept]:
        """Return those that are new among the latest of each name."""
        new = [percept for name, percept in percepts.items() if self._percepts.get(name) is not percept]
        self._percepts.update({percept.name: percept for percept in new})
        return new


def _all_keys(tree: Tree) -> Iterator[tuple[str, Key]]:
    """Yield the keys of a tree and of its sub-trees, these with the path of their node before the name."""
    for key in tree.keys:
        yield key.name, key
    for node in tree.nodes:
        if isinstance(node.behaviour, SubTree):
            for key in node.behaviour.keys:
                yield f"{node.path}/{key.name}", key
