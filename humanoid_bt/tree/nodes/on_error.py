"""The decorator that turns an exception below it into a failure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core.texts import told
from humanoid_bt.tree.nodes.decorators import Decorator
from humanoid_bt.tree.results import Below, Results
from humanoid_bt.tree.ticking.catching import Catcher, halt_all
from humanoid_bt.tree.ticking.tick import FAILURE, Raised, Seen, tick


class OnError(Decorator, Catcher):
    """Run the child, and fail instead of ending the run when a node below raises an exception.

    Everything below is halted in order, children before parents, and released. Each exception is told as a warning of
    the run, with the node's path, its place in the tree file and the line of the skill. So are exceptions that nodes
    below raise while they are halted, by whom ever. `SystemExit` and its like count too. Ctrl-C, two owners of one
    resource and the loss of control do not: they end the run.

    It never hides a mistake: whoever wrote the tree says that a failure is enough here. Where two of them stand above
    the node, the inner one acts.
    """

    def __init__(self, name: str, child: Behaviour, **values: Any) -> None:
        super().__init__(name, child, **values)
        self.on_caught = self.to_log

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
            reason = f"{raised.node.name!r} raised {told(raised.error)}"
            _raise_first(self.take([raised, *halt_all(self.decorated, reason, seen)]))
            self.feedback_message = reason
            return FAILURE

    def halt_child(self, child: Behaviour, reason: str, seen: Seen) -> None:
        """Halt the child, whatever nodes raise meanwhile."""
        _raise_first(self.take(halt_all(child, reason, seen)))


def _raise_first(errors: Sequence[Raised]) -> None:
    for raised in errors:
        raise raised
