"""Composites that choose what runs, once or in every tick: if, switch, reactive_if, reactive_switch."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.errors import any_of
from humanoid_bt.core.params import param
from humanoid_bt.core.units import readable
from humanoid_bt.decision.assign import assign
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions.expression import Expression
from humanoid_bt.tree.expressions.linking import Unseen, choices_of
from humanoid_bt.tree.expressions.quantities import number, read_quantity, type_of
from humanoid_bt.tree.nodes import other_libraries
from humanoid_bt.tree.nodes.family import cases_of, child_of, children_of
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.slots import Slot, Takes
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS, Branch, Seen, halt, tick

_TRUTHS = {"true": True, "false": False}


class Choice(Branch, py_trees.composites.Composite):
    """Base of the nodes that run one of several branches.

    Args:
        name: the node's name.
        branches: what it chooses from.
        condition: a node that is asked which; it is no branch.
        values: its parameters.

    Attributes:
        chosen: the branch that runs, None if none does.
    """

    takes: ClassVar[Takes] = "none"

    def __init__(
        self, name: str, branches: Iterable[Behaviour], condition: Behaviour | None = None, **values: Any
    ) -> None:
        self._choices = list(branches)
        asked = [] if condition is None else [condition]
        super().__init__(name, children_of(type(self), name, [*asked, *self._choices]))
        other_libraries.refuse_parameters(self, values)
        assign(self, values)
        self.chosen: Behaviour | None = None

    def initialise(self) -> None:
        """Choose anew."""
        self.chosen = self.current_child = None

    def run(self, chosen: Behaviour, reason: str, seen: Seen) -> Status:
        """Tick a branch, and halt the one that was chosen before if it is another."""
        if chosen is not self.chosen:
            self._halt_others(chosen, reason, seen)
        self.chosen = self.current_child = chosen
        return tick(chosen, seen)

    def leave(self, reason: str, seen: Seen) -> None:
        """Halt what was chosen before: nothing is chosen now."""
        self._halt_others(None, reason, seen)
        self.chosen = None

    def _halt_others(self, chosen: Behaviour | None, reason: str, seen: Seen) -> None:
        """Halt the branch that ran, and take away what others came to the last time."""
        for branch in self._choices:
            if branch is not chosen and branch.status is not INVALID:
                halt(branch, reason, seen)


class _If(Choice):
    """Runs the branch that its condition chooses; asks it in every tick."""

    branches: ClassVar[dict[str, Slot]] = {
        "condition": Slot("What decides: an expression or a node.", required=True, condition=True),
        "then": Slot("What runs if it holds.", required=True),
        "else": Slot("What runs if it does not; without it, fail."),
    }
    needs: ClassVar[dict[str, Status]] = {"then": SUCCESS, "else": FAILURE}
    """The condition's result with which a branch gets its turn."""

    def __init__(
        self, name: str, condition: Behaviour, then: Behaviour, else_: Behaviour | None = None, **values: Any
    ) -> None:
        self.condition, self.then, self.else_ = child_of(type(self), name, condition, "condition"), then, else_
        super().__init__(name, [then, *([] if else_ is None else [else_])], condition, **values)

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
        status = tick(self.condition, seen)
        self.current_child = self.condition
        if status is RUNNING:
            self.leave("its condition is being checked", seen)
            return RUNNING
        chosen = self.then if status is SUCCESS else self.else_
        words = f"its condition {'holds' if status is SUCCESS else 'does not hold'} now"
        if chosen is None:
            self.leave(words, seen)
            return FAILURE
        return self.run(chosen, words, seen)


class If(_If):
    """Run `then` if a condition holds, else `else`, to its end; fail if it does not hold and there is no `else`.

    The condition is asked up to its first answer, and no more while the branch runs: if it is a node that is RUNNING,
    so is the `if`. To change the branch when the condition changes, use `reactive_if`.
    """

    one_way: ClassVar[bool] = True
    """Whether the condition decides once in a run of the node, so that it cannot flap."""

    def advance(self, seen: Seen) -> Status:
        """Go on with the branch that was chosen, or choose one."""
        return super().advance(seen) if self.chosen is None else tick(self.chosen, seen)


class ReactiveIf(_If):
    """Run `then` while a condition holds, `else` while it does not; fail if there is no `else`.

    The condition is asked in every tick: when it changes, the branch that runs is halted and the other one starts. If
    it is a node that is RUNNING, so is the `reactive_if`, and neither branch runs.
    """

    goes_on: ClassVar[str] = "if"
    """The type that goes on with what runs instead of asking again in every tick."""


class _Switch(Choice):
    """Runs the case of a value, which it computes in every tick."""

    branches: ClassVar[dict[str, Slot]] = {
        "cases": Slot("What runs, by value.", required=True, many=True),
        "default": Slot("What runs when no case has the value; without it, fail."),
    }

    value: Expression = param(doc="What decides.")

    def __init__(
        self,
        name: str,
        cases: Mapping[str | bool | float, Behaviour],
        default: Behaviour | None = None,
        **values: Any,
    ) -> None:
        self.cases = cases_of(type(self), name, cases)
        super().__init__(name, [*self.cases.values(), *([] if default is None else [default])], **values)
        self.default = default
        self._truths = {_TRUTHS[text]: branch for text, branch in self.cases.items() if text in _TRUTHS}
        self._numbers: dict[float, Behaviour] = {}
        for text, branch in self.cases.items():
            value = self._number(text)
            if value is not None and self._numbers.setdefault(value, branch) is not branch:
                raise ValueError(f"two of its cases are the number {value:g}")

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the results of every branch, and FAILURE: it may find none."""
        return frozenset({FAILURE}).union(*below.branches.values())

    @classmethod
    def results_at_once(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return what every branch can answer at once, and FAILURE if there may be none."""
        found = frozenset().union(*below.branches.values())
        return found if "default" in below.branches else found | {FAILURE}

    def setup(self, **kwargs: Any) -> None:
        """Take ``robot``."""
        self.robot: Robot = kwargs["robot"]

    def initialise(self) -> None:
        """Choose anew; forget what held if its branch was left."""
        super().initialise()
        if self.status is INVALID:
            self.value.forget()

    def advance(self, seen: Seen) -> Status:
        """Compute the value and tick the branch that it chooses."""
        try:
            value = self.value.evaluate(self.robot)
        except Unseen as unseen:
            return self._nothing(str(unseen), seen)
        words = f"{self.value} is {readable(value)}"
        chosen = self._case(value)
        if chosen is None:
            return self._nothing(f"{words}: no case", seen)
        self.feedback_message = words
        return self.run(chosen, words, seen)

    def _nothing(self, why: str, seen: Seen) -> Status:
        self.feedback_message = why
        self.leave(why, seen)
        self.current_child = None
        return FAILURE

    def _case(self, value: Any) -> Behaviour | None:
        if isinstance(value, bool):
            found = self._truths.get(value)
        elif isinstance(value, (int, float)):
            found = self._numbers.get(value)
        else:
            found = self.cases.get(value) if isinstance(value, str) else None
        return found or self.default

    def _number(self, text: str) -> float | None:
        """Return a case as a number, None if it is none, or if the value is text, which may look like a number.

        Raises:
            ValueError: the value can never be this.
        """
        wanted = self.value.type
        if wanted.kind == "text":
            if (choices := choices_of(self.value.syntax)) and text not in choices:
                raise ValueError(f"the case {text!r} is never chosen: {str(self.value)!r} is {any_of(choices)}")
            return None
        digits = text.removeprefix("-").lstrip()
        found = read_quantity(digits, 0)
        if found is not None and found[2] < len(digits):
            found = None
        kind = number(found[1]) if found else type_of(_TRUTHS.get(text, text))
        if not wanted.goes_with(kind):
            raise ValueError(f"the case {text!r} is never chosen: {str(self.value)!r} is {wanted}")
        return None if found is None else found[0] if digits == text else -found[0]


class Switch(_Switch):
    """Run the case that has a value's name, else `default`, to its end; fail if there is neither.

    The value is computed once, when the node starts; to change the branch when the value changes, use
    `reactive_switch`. If it asks for a percept that was never seen the node fails.

    A text chooses the case that is written like it, a truth value `true` or `false`, and a number the case that is
    equal to it, such as `2` or `50 cm`.
    """

    one_way: ClassVar[bool] = True

    def advance(self, seen: Seen) -> Status:
        """Go on with the branch that was chosen, or choose one."""
        return super().advance(seen) if self.chosen is None else tick(self.chosen, seen)


class ReactiveSwitch(_Switch):
    """Run the case that has a value's name as long as it has it, else `default`; fail if there is neither.

    The value is computed in every tick: if it chooses another branch, the one that runs is halted and the other one
    starts. If it asks for a percept that was never seen the node fails, and what runs is halted.

    Cases are compared as those of `switch`.
    """
