"""Composites that choose what runs: if."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.params import assign, param
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.slots import Slot, Takes
from humanoid_bt.tree.ticking import FAILURE, INVALID, RUNNING, SUCCESS, Branch, Seen, halt, tick


class Choice(Branch, py_trees.composites.Composite):
    """Base of the nodes that run one of several branches."""

    takes: ClassVar[Takes] = "none"

    def __init__(self, name: str, branches: list[Behaviour], **values: Any) -> None:
        super().__init__(name, branches)
        assign(self, values)
        self.chosen: Behaviour | None = None

    def initialise(self) -> None:
        """Choose anew."""
        self.chosen = None

    def run(self, chosen: Behaviour, reason: str, seen: Seen) -> Status:
        """Tick a branch, and halt the one that was chosen before if it is another."""
        before, self.chosen = self.chosen, chosen
        if before is not None and before is not chosen and before.status is not INVALID:
            halt(before, reason, seen)
        self.current_child = chosen
        return tick(chosen, seen)

    def leave(self, reason: str, seen: Seen) -> None:
        """Halt what was chosen before: nothing is chosen now."""
        if self.chosen is not None and self.chosen.status is not INVALID:
            halt(self.chosen, reason, seen)
        self.chosen = None


class If(Choice):
    """Run `then` while a condition holds, else `else`; fail if it does not hold and there is no `else`.

    The condition is checked in every tick: if it changes, the branch that runs is halted and the other one starts.
    With `memory` it is checked once and the branch then runs to its end.
    """

    branches: ClassVar[dict[str, Slot]] = {
        "condition": Slot("What decides: an expression or a node.", required=True, condition=True),
        "then": Slot("What runs while it holds.", required=True),
        "else": Slot("What runs while it does not; without it, fail."),
    }
    needs: ClassVar[dict[str, Status]] = {"then": SUCCESS, "else": FAILURE}
    """The condition's result with which a branch gets its turn."""

    memory: bool = param(False, doc="Check the condition only at the start.")

    def __init__(
        self, name: str, condition: Behaviour, then: Behaviour, else_: Behaviour | None = None, **values: Any
    ) -> None:
        super().__init__(name, [condition, then, *([else_] if else_ else [])], **values)
        self.condition, self.then, self.else_ = condition, then, else_

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the results of the branches that the condition can choose."""
        condition = below.branches["condition"]
        found = condition & {RUNNING}
        for branch, needed in cls.needs.items():
            if needed in condition:
                found |= below.branches.get(branch, {FAILURE})
        return found

    def advance(self, seen: Seen) -> Status:
        """Check the condition and tick the branch that it chooses."""
        if self.chosen is not None and self.memory:
            return tick(self.chosen, seen)
        status = tick(self.condition, seen)
        if status is RUNNING:
            self.leave("its condition is being checked", seen)
            return RUNNING
        chosen = self.then if status is SUCCESS else self.else_
        words = f"its condition {'holds' if status is SUCCESS else 'does not hold'} now"
        if chosen is None:
            self.leave(words, seen)
            return FAILURE
        return self.run(chosen, words, seen)
