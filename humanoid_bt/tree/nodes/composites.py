"""Sequence and selector: those that go on with the child that runs, and the reactive ones, which ask again."""

from __future__ import annotations

from collections.abc import Mapping
from collections.abc import Sequence as SequenceOf
from itertools import islice
from typing import Any, ClassVar

import py_trees
from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.decision.assign import assign
from humanoid_bt.tree.nodes import other_libraries
from humanoid_bt.tree.nodes.family import children_of
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.ticking.tick import FAILURE, INVALID, RUNNING, SUCCESS, Branch, Seen, halt, tick

_DID = {SUCCESS: "succeeded", FAILURE: "failed", RUNNING: "runs"}


class _Ordered(Branch):
    """Ticks its children in order up to the first whose status is not ``passed``."""

    passed: ClassVar[Status]
    """The status of a child with which the next one gets its turn."""
    one_way: ClassVar[bool]
    """Whether it goes on with the child that runs, and asks those before it no more in this run."""

    memory: bool  # py_trees' name of it, for its tools

    def __init__(self, name: str, children: SequenceOf[Behaviour], **values: Any) -> None:
        children = children_of(type(self), name, children)
        # py_trees' own composite, which comes next in the order of classes, takes these
        super().__init__(name, memory=self.one_way, children=children)  # type: ignore[call-arg]
        other_libraries.refuse_parameters(self, values)
        assign(self, values)

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return what the children can answer, up to one that never lets the next have its turn."""
        found: set[Status] = set()
        for child in below.children:
            found |= child - {cls.passed}
            if cls.passed not in child:
                return frozenset(found)
        return frozenset(found | {cls.passed})

    def initialise(self) -> None:
        """Start with the first child."""
        self.current_child: Behaviour | None = None

    def advance(self, seen: Seen) -> Status:
        """Tick children in order; what ran behind the one that decides is preempted."""
        children, passed = iter(self.children), self.passed
        if self.memory and self.current_child is not None:
            children = islice(children, self.children.index(self.current_child), None)
        for child in children:
            status = tick(child, seen)
            if status is not passed:
                break
        for later in children:  # none, unless a child decided
            if later.status is not INVALID:
                halt(later, f"preempted by {child.name!r}, which {_DID[status]}", seen)
        self.current_child = child
        return status


class Sequence(_Ordered, py_trees.composites.Sequence):
    """Run the children in order, each to its end, while they succeed; fail with the first that fails.

    A child that has succeeded is not asked again. To check what must go on holding, use `reactive_sequence`.
    """

    passed = SUCCESS
    one_way = True


class Selector(_Ordered, py_trees.composites.Selector):
    """Try the children in order, each to its end, until one succeeds; fail if all fail.

    A child that has failed is not asked again. To try the first ones again while a later one runs, use
    `reactive_selector`.
    """

    passed = FAILURE
    one_way = True


class ReactiveSequence(_Ordered, py_trees.composites.Sequence):
    """Ask the children in order in every tick, up to the first that does not succeed.

    For conditions and what runs only while they hold: when one of them no longer succeeds, what runs behind it is
    halted. A child that has run and succeeded starts again in the next tick; to do one thing after the other, use
    `sequence`.
    """

    passed = SUCCESS
    one_way = False
    goes_on: ClassVar[str] = "sequence"
    """The type that goes on with what runs instead of asking again in every tick."""


class ReactiveSelector(_Ordered, py_trees.composites.Selector):
    """Ask the children in order in every tick, up to the first that does not fail.

    For what the robot does as soon as it can, and what it does otherwise: when an earlier child no longer fails, what
    runs behind it is halted. A child that has run and failed starts again in the next tick; to try one thing after the
    other, use `selector`.
    """

    passed = FAILURE
    one_way = False
    goes_on: ClassVar[str] = "selector"
