"""What a node can answer when it is ticked, as far as its file tells: the ground of the checks on reachability.

A node type says it with a class method ``possible_results(values, below)``, with its parameters (defaults put in) and
what can come from below it. One without it may answer anything, a condition anything but RUNNING. A set may hold too
much, never too little: what is missing from it never comes.

What a node can answer *at once*, in the tick in which it starts and without starting anything that runs, follows from
that: what never runs answers at once, a leaf that may run does not, and any other node answers what it makes of what
those below it answer at once. Where that is not so, a class method ``results_at_once(values, below)`` says it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from py_trees.common import Status

Results = frozenset[Status]
"""The statuses that ticks of a node can return."""

ANYTHING: Results = frozenset({Status.SUCCESS, Status.FAILURE, Status.RUNNING})
AT_ONCE: Results = frozenset({Status.SUCCESS, Status.FAILURE})
"""Of a node that is never RUNNING."""
NEVER_ENDS: Results = frozenset({Status.RUNNING})
"""Of a node that runs until it is halted."""
SUCCEEDS: Results = frozenset({Status.SUCCESS})
NOTHING: Results = frozenset()
"""Of a node that cannot answer at once."""


@dataclass(frozen=True)
class Below:
    """What can come from the nodes below a node.

    Attributes:
        children: from its children, in order.
        branches: from its other branches, by their key: ``then``, ``cases left``.
    """

    children: tuple[Results, ...] = ()
    branches: Mapping[str, Results] = field(default_factory=dict)

    @property
    def child(self) -> Results:
        """From its only child."""
        return self.children[0]
