"""Breakpoints: at a node, when it starts or gets a status, or at an expression, when it becomes true."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator
from typing import Any, Protocol

from py_trees.common import Status

from humanoid_bt.core.errors import HumanoidBtError, Place, UserError, nearest
from humanoid_bt.core.messages import Pause
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.expressions.expression import Truth
from humanoid_bt.tree.expressions.linking import Unseen
from humanoid_bt.tree.expressions.quantities import ANYTHING, Type, type_of
from humanoid_bt.tree.source.scope import declared_type
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree

STATUSES = {status.name: status for status in Status} | {"HALTED": Status.INVALID}
"""What a breakpoint can name behind ``=``."""

_AT_STATUS = re.compile(r"(?P<node>.*[^=<>!])=(?!=)\s*(?P<status>\w*)\s*")
_NODE = re.compile(r"[^<>=!()+*.]+")  # no expression but a name, or a node's path


class Breakpoint(Protocol):
    """Where a run pauses.

    Attributes:
        text: as it was written.
    """

    text: str

    def find(self, tree: Tree) -> None:
        """Look up its names in the tree that runs from now on.

        Raises:
            UserError: they mean nothing there.
        """

    def changed(self, change: NodeChange, before: Status) -> Pause | None:
        """Return the pause that a node's change of status brings, if it does."""

    def ticked(self, robot: Robot) -> Pause | None:
        """Return the pause that a tick brings, if it does."""


class NodeBreak:
    """A breakpoint at nodes.

    Args:
        text: as it was written.
        end: what the path of such a node ends with.
        status: the status at which it pauses; None for the tick in which the node starts.
    """

    def __init__(self, text: str, end: str, status: Status | None) -> None:
        self.text, self._end, self._status = text, end, status
        self._paths: frozenset[str] = frozenset()

    def find(self, tree: Tree) -> None:
        """Find the nodes; raises UserError if there are none."""
        self._paths = _ending(tree, self._end)
        if not self._paths:
            tree.node(self._end)

    def changed(self, change: NodeChange, before: Status) -> Pause | None:
        """Pause when one of them starts, or gets the status."""
        if change.path not in self._paths:
            return None
        ran, halted = before is Status.RUNNING, change.status is Status.INVALID
        if halted and not ran and not change.feedback:
            return None  # what it had answered is forgotten
        if ran if self._status is None else change.status is not self._status:
            return None
        says = change.feedback if change.status is Status.INVALID else f"{change.status.name}: {change.feedback}"
        return Pause(f"break at {change.path}", says.removesuffix(": ") or "halted")

    def ticked(self, robot: Robot) -> Pause | None:
        """Return None."""
        return None


class ExpressionBreak:
    """A breakpoint at an expression, which pauses when that becomes true.

    Args:
        text: as it was written.
        percepts: those that there may be.

    Raises:
        UserError: it is no expression.
    """

    def __init__(self, text: str, percepts: Collection[str]) -> None:
        self.text, self._percepts = text, percepts
        self._expression = Truth.parse(text, _place(), 0)
        self._held = False

    def find(self, tree: Tree) -> None:
        """Look up what it asks for; raises UserError."""
        self._expression.link(NamesOf(tree))
        for name in self._expression.percepts:
            if name not in self._percepts:
                hint = nearest(name, self._percepts) or "it publishes none"
                raise UserError(f"in {self.text!r}: no percept source publishes {name!r}", _place(), hint)

    def changed(self, change: NodeChange, before: Status) -> Pause | None:
        """Return None."""
        return None

    def ticked(self, robot: Robot) -> Pause | None:
        """Pause when it is true and was not before; what was never seen, or has no value, is not true."""
        before, self._held = self._held, holds(self._expression, robot)
        return Pause(f"break at {self.text}", self._expression.explain()) if self._held and not before else None


def holds(expression: Truth, robot: Robot) -> bool:
    """Return whether an expression is true; what was never seen, or has no value, is not."""
    try:
        return bool(expression.evaluate(robot))
    except (Unseen, HumanoidBtError, TypeError, ArithmeticError):
        return False


def breakpoint_at(text: str, tree: Tree, percepts: Collection[str]) -> Breakpoint:
    """Return a breakpoint: ``reach``, ``reach=FAILURE`` or ``distance(target) < 0.5 m``.

    Args:
        text: what is written so.
        tree: the tree that runs.
        percepts: those that its scene publishes.

    Raises:
        UserError: it names no node of the tree and is no expression either.
    """
    if not isinstance(text, str) or not text.strip():
        raise UserError(f"a breakpoint is a node or an expression, not {text!r}", hint=_EXAMPLES, code="wrong-type")
    text = text.strip()
    found = _breakpoint(text, tree, percepts)
    found.find(tree)
    return found


_EXAMPLES = "like reach, reach=FAILURE or 'distance(target) < 0.5 m'"


def _breakpoint(text: str, tree: Tree, percepts: Collection[str]) -> Breakpoint:
    if _ending(tree, text):
        return NodeBreak(text, text, None)
    at_status = _AT_STATUS.fullmatch(text)
    if at_status is not None and (_NODE.fullmatch(at_status["node"]) or _ending(tree, at_status["node"].strip())):
        status = at_status["status"].upper()
        if status not in STATUSES:
            message = f"{text!r} pauses at no status of a node: {at_status['status']!r}"
            raise UserError(message, hint=nearest(status, STATUSES), code="wrong-choice")
        return NodeBreak(text, at_status["node"].strip(), STATUSES[status])
    if _NODE.fullmatch(text) and not set(re.findall(r"\w+", text)) & {"and", "or", "not", *NamesOf(tree).known}:
        return NodeBreak(text, text, None)
    return ExpressionBreak(text, percepts)


def _ending(tree: Tree, end: str) -> frozenset[str]:
    """Return the paths of nodes that end so."""
    return frozenset(node.path for node in tree.nodes if f"/{node.path}".endswith(f"/{end}"))


def _place() -> Place:
    return Place("breakpoint", 1, 1)


class NamesOf:
    """What names mean in an expression that is asked of a tree from outside.

    Args:
        tree: the tree, whose keys and parameters have names.
    """

    def __init__(self, tree: Tree) -> None:
        self._parameters = tree.parameters
        self._keys = {key.name: key for key in tree.keys}

    @property
    def fixed(self) -> Collection[str]:
        """The names of all parameters whose value is known before the run."""
        return self._parameters

    @property
    def known(self) -> Iterator[str]:
        """The names of all parameters and keys."""
        yield from self._parameters
        yield from self._keys

    def value(self, name: str) -> tuple[Type, Callable[[], Any]] | None:
        """Return type and value of a parameter or a key, None if there is none of this name."""
        if (key := self._keys.get(name)) is not None:
            return ANYTHING if key.spec is None else declared_type(key.spec), lambda: key.value
        if name in self._parameters:
            value = self._parameters[name]
            return type_of(value), lambda: value
        return None

    def percept(self, name: str) -> str:
        """Return the percept that a name means: a parameter's value, else the name itself."""
        value = self._parameters.get(name)
        return value if isinstance(value, str) else name

    def is_set(self, name: str) -> Callable[[], bool] | None:
        """Return what tells whether a key has a value, None if there is no such key."""
        key = self._keys.get(name)
        return None if key is None else lambda: key.is_set
