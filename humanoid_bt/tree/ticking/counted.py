"""Counting what nodes do, one by one: not all that begins and ends within a tick is told."""

from __future__ import annotations

from py_trees.behaviour import Behaviour

from humanoid_bt.tree.counting import Tally
from humanoid_bt.tree.ticking.tick import Seen


class Counted(Seen):
    """Nodes ticked or halted so far, each counted as it comes.

    Args:
        tally: what counts them.
    """

    def __init__(self, tally: Tally) -> None:
        super().__init__()
        self._tally = tally

    def append(self, node: Behaviour) -> None:
        """Take one more node, whose status is that of now."""
        self._tally.touched(node)
        super().append(node)
