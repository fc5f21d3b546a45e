"""Decorators that ask a condition before they run their child: precondition, guard, while."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.tree.nodes.decorators import Decorator
from humanoid_bt.tree.nodes.family import child_of
from humanoid_bt.tree.nodes.told_when_asked import ToldWhenAsked
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.slots import Slot
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS, Seen, halt, tick


class Conditional(ToldWhenAsked, Decorator):
    """Base of the decorators with a condition; it is asked in every tick unless a subclass says otherwise.

    While the condition is a node that is RUNNING, so is the decorator, and its child does not run.

    Attributes:
        otherwise: its status when the condition does not hold.
    """

    branches: ClassVar[dict[str, Slot]] = {
        "condition": Slot("What must hold: an expression or a node.", required=True, condition=True)
    }
    otherwise: ClassVar[Status] = FAILURE
    needs: ClassVar[dict[str, Status]] = {"": SUCCESS}
    """The condition's result with which the child gets its turn."""

    def __init__(self, name: str, child: Behaviour, condition: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self.condition = child_of(type(self), name, condition, "condition")
        self.children.insert(0, condition)
        condition.parent = self

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return what the condition and, if it can hold, the child come to."""
        condition = below.branches["condition"]
        found = condition & {RUNNING} | ({cls.otherwise} if FAILURE in condition else set())
        return found | cls.results_of_child(below.child) if SUCCESS in condition else found

    @classmethod
    def results_of_child(cls, child: Results) -> Results:
        """Return the results that come of the child's."""
        return child

    def asks_again(self, child: Behaviour) -> bool:
        """Return whether it is the condition."""
        return child is self.condition

    def advance(self, seen: Seen) -> Status:
        """Ask the condition, then tick the child."""
        status = tick(self.condition, seen)
        if status is SUCCESS:
            self.feedback_message = ""
            return self.proceed(seen)
        if status is RUNNING:
            self.feedback_message = "its condition is being checked"
        else:
            self.say(self._why_not)
        if self.decorated.status is not INVALID:
            halt(self.decorated, self.feedback_message, seen)
        return RUNNING if status is RUNNING else self.otherwise

    def _why_not(self) -> str:
        words = self.condition.feedback_message
        return f"its condition does not hold: {words}" if words else "its condition does not hold"

    def proceed(self, seen: Seen) -> Status:
        """Tick the child: the condition holds."""
        return tick(self.decorated, seen)

    def tip(self) -> Behaviour | None:
        """Return the deepest node of what was ticked last."""
        asked = self.decorated.status is INVALID and self.condition.status is not INVALID
        return self.condition.tip() if asked else super().tip()


class Precondition(Conditional):
    """Start the child only if a condition holds, else fail.

    The condition is asked when the child is to be started, and no more once it runs. If it is a node that is RUNNING,
    so is the `precondition`, until it has its answer.
    """

    one_way: ClassVar[bool] = True
    """Whether the condition decides once in a run of the node, so that it cannot flap."""

    def advance(self, seen: Seen) -> Status:
        """Ask the condition unless the child runs."""
        if self.decorated.status is RUNNING:
            return self.proceed(seen)
        return super().advance(seen)


class Guard(Conditional):
    """Run the child only while a condition holds; halt it and fail when it does not.

    The condition is asked in every tick, before the child. If it is a node that is RUNNING, so is the `guard`, and
    its child is halted: nothing runs whose guard is in doubt.
    """

    goes_on: ClassVar[str] = "precondition"
    """The type that goes on with what runs instead of asking again in every tick."""


class While(Conditional):
    """Run the child again and again while a condition holds, then succeed; fail when the child fails.

    The condition is asked in every tick, before the child; when it no longer holds, the child is halted if it runs.
    One run of the child per tick at most. If the condition is a node that is RUNNING, so is the `while`, and its child
    is halted.
    """

    otherwise = SUCCESS
    bounded: ClassVar[bool] = False
    one_way: ClassVar[bool] = True

    @classmethod
    def results_of_child(cls, child: Results) -> Results:
        """Return the child's results; a success after which it runs again is RUNNING."""
        return child - {SUCCESS} | {RUNNING} if SUCCESS in child else child

    def proceed(self, seen: Seen) -> Status:
        """Tick the child; when it succeeds, go on."""
        status = tick(self.decorated, seen)
        return RUNNING if status is SUCCESS else status
