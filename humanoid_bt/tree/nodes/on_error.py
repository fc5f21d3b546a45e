"""The decorator that turns an exception below it into a failure."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.errors import ControlLost, ResourceConflict
from humanoid_bt.tree.nodes.decorators import Decorator
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.ticking import FAILURE, INVALID, Branch, Raised, Seen, halt_alone, tick

_log = logging.getLogger(__name__)

_NOT_CAUGHT = (ControlLost, ResourceConflict)


class OnError(Decorator):
    """Run the child, and fail instead of ending the run when a node below raises an exception.

    Everything below is halted in order, children before parents, and released. Each exception is told as a warning of
    the run, with the node's path, its place in the tree file and the line of the skill. So are exceptions that nodes
    below raise while they are halted, by whom ever. `SystemExit` counts; Ctrl-C, two owners of one resource and the
    loss of control do not: they end the run.

    It never hides a mistake: whoever wrote the tree says that a failure is enough here. Where two of them stand above
    the node, the inner one acts.
    """

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self.on_caught: Callable[[Raised], None] = self._to_log

    @classmethod
    def possible_results(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's results, and FAILURE: it may raise."""
        return below.child | {FAILURE}

    @classmethod
    def results_at_once(cls, _values: Mapping[str, Any], below: Below) -> Results:
        """Return the child's: nothing counts on an exception."""
        return below.child

    def advance(self, seen: Seen) -> Status:
        """Tick the child; fail if anything below raises."""
        try:
            return tick(self.decorated, seen)
        except Raised as raised:
            reason = f"{raised.node.name!r} raised {type(raised.error).__name__}: {raised.error}"
            _raise_first(self.take([raised, *_halt_all(self.decorated, reason, seen)]))
            self.feedback_message = reason
            return FAILURE

    def halt_child(self, child: Behaviour, reason: str, seen: Seen) -> None:
        """Halt the child, whatever nodes raise meanwhile."""
        _raise_first(self.take(_halt_all(child, reason, seen)))

    def take(self, errors: Sequence[Raised]) -> list[Raised]:
        """Tell of exceptions below; return those that are not for this node."""
        others = [raised for raised in errors if isinstance(raised.error, _NOT_CAUGHT)]
        for raised in errors:
            if raised not in others:
                self.on_caught(raised)
        return others

    def _to_log(self, raised: Raised) -> None:
        _log.warning("%s caught what %s raised", self.name, raised.node.name, exc_info=raised.error)


def catch(raised: Raised) -> bool:
    """Let the nearest ``on_error`` above a node take what it raised; return whether one did."""
    above = raised.node.parent
    while above is not None and not isinstance(above, OnError):
        above = above.parent
    return isinstance(above, OnError) and not above.take([raised])


def _halt_all(node: Behaviour, reason: str, seen: Seen) -> list[Raised]:
    """Halt a node and everything below it, whatever state an exception left them in.

    Returns:
        What they raise, but for what an ``on_error`` below takes.
    """
    found: list[Raised] = []
    if isinstance(node, Branch):
        for child in node.children:
            found += _halt_all(child, reason, seen)
    if isinstance(node, OnError):
        found = node.take(found)
    if node.status is INVALID:
        return found
    try:
        halt_alone(node, reason, seen)
    except Raised as raised:
        found.append(raised)
    return found


def _raise_first(errors: Sequence[Raised]) -> None:
    for raised in errors:
        raise raised
