"""Decorators that run one child again and again: for_each, keep_running_until_failure."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import zip_longest
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.params import param
from humanoid_bt.core.units import readable
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.tree.nodes.decorators import Decorator
from humanoid_bt.tree.results import SUCCEEDS, Below, Results
from humanoid_bt.tree.ticking.tick import RUNNING, SUCCESS, Seen, tick


class ForEach(Decorator):
    """Run the child once for each item of a list, which it finds in a key of the blackboard; fail when it fails.

    If `item` is a list of keys, each item is a list too, and its parts go to the keys in their order; keys that are
    left over get null. One run per tick at most; with an empty list it succeeds.
    """

    item: Key | list[Key] = param(doc="Key that gets one item after the other, or keys that get its parts.")
    items: list[Any] = param(doc="The items.")

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        if isinstance(self.item, list):
            self.item = [Key(part) if isinstance(part, str) else part for part in self.item]
        self.check_values()

    def check_values(self) -> None:
        """Refuse items without a part for the keys, or with more parts than there are keys."""
        if isinstance(self.item, list):
            _check_parts(self.items, [key.name for key in self.item])

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, RUNNING between two items, and SUCCESS of an empty list."""
        return below.child | {SUCCESS, RUNNING}

    @classmethod
    def results_at_once(cls, values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's, but for a success after which there are more items."""
        if not values["items"]:
            return SUCCEEDS
        return below.child if len(values["items"]) == 1 else below.child - {SUCCESS}

    def initialise(self) -> None:
        """Begin with the first item of those that there are now."""
        self._items, self._index = self.items, 0  # of this run

    def advance(self, seen: Seen) -> Status:
        """Tick the child with the item whose turn it is."""
        if self._index == len(self._items):
            return SUCCESS
        if self.decorated.status is not RUNNING:
            self._hand_out(self._items[self._index])
        status = tick(self.decorated, seen)
        names = self.item.name if isinstance(self.item, Key) else ", ".join(key.name for key in self.item)
        self.feedback_message = f"{names} {self._index + 1} of {len(self._items)}: {readable(self._items[self._index])}"
        if status is not SUCCESS:
            return status
        self._index += 1
        return SUCCESS if self._index == len(self._items) else RUNNING

    def _hand_out(self, item: Any) -> None:
        if isinstance(self.item, Key):
            self.item.set(item)
        else:
            for key, part in zip_longest(self.item, item):
                key.put(None) if part is None else key.set(part)  # whatever it is declared to be


def _check_parts(items: list[Any], keys: list[str]) -> None:
    for number, item in enumerate(items, 1):
        if not isinstance(item, (list, tuple)) or not 0 < len(item) <= len(keys):
            raise ValueError(f"item {number} must be a list with at most {len(keys)} parts ({', '.join(keys)}): {item}")


class KeepRunningUntilFailure(Decorator):
    """Run the child again when it succeeds, one run per tick; fail when it fails.

    It never succeeds. BehaviorTree.CPP's node of this name ends with failure as well. `repeat` without `times` is the
    same.
    """

    bounded: ClassVar[bool] = False

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results; a success after which it runs again is RUNNING."""
        return below.child - {SUCCESS} | {RUNNING} if SUCCESS in below.child else below.child

    def advance(self, seen: Seen) -> Status:
        """Tick the child; when it succeeds, go on."""
        status = tick(self.decorated, seen)
        return RUNNING if status is SUCCESS else status
