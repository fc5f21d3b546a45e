"""Giving the next tick of one node a result from outside."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.tree.ticking.tick import INVALID, RUNNING, Branch, Seen


def force(node: Behaviour, status: Status, why: str) -> None:
    """Let the next tick of a node give a status, once, whatever it would do.

    What runs below it is halted then. A leaf ends as it does by itself: it is started if it does not run, told to
    stop, and gives back what it commands.

    Args:
        node: the node.
        status: SUCCESS or FAILURE.
        why: its feedback then, and the reason of the halt below.
    """
    how = "advance" if isinstance(node, Branch) else "update" if type(node).tick is Behaviour.tick else "tick"
    own: Any = vars(node).get(how)

    def forget() -> None:
        if own is None:
            vars(node).pop(how, None)
        else:
            vars(node)[how] = own
        node.feedback_message = why

    def advance(seen: Seen) -> Status:
        assert isinstance(node, Branch)
        forget()
        for child in node.children:
            if child.status is RUNNING:
                node.halt_child(child, why, seen)
        return status

    def update() -> Status:
        forget()
        return status

    def ticked() -> Iterator[Behaviour]:  # it has children inside that only it knows
        forget()
        node.stop(INVALID)
        node.status = status
        yield node

    vars(node)[how] = {"advance": advance, "update": update, "tick": ticked}[how]
