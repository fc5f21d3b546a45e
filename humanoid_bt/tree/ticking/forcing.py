"""Giving the next tick of one node a result from outside."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.tree.ticking.tick import INVALID, RUNNING, Branch, Seen


def force(node: Behaviour, status: Status, why: str) -> None:
    """Let the next tick of a node give a status, once, whatever it would do.

    What runs below it is halted then, and a node with children that runs is told of it as of a halt. A leaf ends as it
    does by itself: it is started if it does not run, told to stop, and gives back what it commands.

    Args:
        node: the node.
        status: SUCCESS or FAILURE.
        why: its feedback then, and the reason of the halt below.
    """
    how = "advance" if isinstance(node, Branch) else "update" if type(node).tick is Behaviour.tick else "tick"
    own: Any = vars(node).get(how)
    if isinstance(own, _Forced):  # what was forced before and has not happened is forgotten
        own = own.own

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
        if node.status is RUNNING:
            node.terminate(INVALID)
        return status

    def update() -> Status:
        forget()
        return status

    def ticked() -> Iterator[Behaviour]:  # it has children inside that only it knows
        forget()
        node.stop(INVALID)
        node.status = status
        yield node

    does: dict[str, Callable[..., Any]] = {"advance": advance, "update": update, "tick": ticked}
    vars(node)[how] = _Forced(does[how], own)


@dataclass(frozen=True)
class _Forced:
    """What a node does once in place of what it does by itself.

    Attributes:
        does: this.
        own: what stood in the place of its class's method before, None if nothing did.
    """

    does: Callable[..., Any]
    own: Any

    def __call__(self, *arguments: Any) -> Any:
        return self.does(*arguments)
