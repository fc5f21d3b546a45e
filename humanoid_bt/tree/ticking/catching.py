"""What happens to the exception of a node that stands below one which takes exceptions (``on_error``)."""

from __future__ import annotations

import logging
from collections.abc import Callable, Sequence

from py_trees.behaviour import Behaviour

from humanoid_bt.core.errors import ControlLost, ResourceConflict
from humanoid_bt.tree.ticking.tick import INVALID, Branch, Raised, Seen, halt_alone

_log = logging.getLogger(__name__)

_NOT_CAUGHT = (ControlLost, ResourceConflict)


class Catcher(Branch):
    """A node that takes what nodes below it raise.

    Attributes:
        on_caught: told of each exception that it takes.
    """

    on_caught: Callable[[Raised], None]

    def take(self, errors: Sequence[Raised]) -> list[Raised]:
        """Tell of exceptions below; return those that are not for this node."""
        others = [raised for raised in errors if isinstance(raised.error, _NOT_CAUGHT)]
        for raised in errors:
            if raised not in others:
                self.on_caught(raised)
        return others

    def to_log(self, raised: Raised) -> None:
        """Tell the program's log of an exception."""
        _log.warning("%s caught what %s raised", self.name, raised.node.name, exc_info=raised.error)


def catch(raised: Raised) -> bool:
    """Let the nearest node above that takes exceptions take what a node raised; return whether one did."""
    above = raised.node.parent
    while above is not None and not isinstance(above, Catcher):
        above = above.parent
    return isinstance(above, Catcher) and not above.take([raised])


def halt_all(node: Behaviour, reason: str, seen: Seen) -> list[Raised]:
    """Halt a node and everything below it, whatever state an exception left them in.

    Returns:
        What they raise, but for what is taken below.
    """
    found: list[Raised] = []
    if isinstance(node, Branch):
        for child in node.children:
            found += halt_all(child, reason, seen)
    if isinstance(node, Catcher):
        found = node.take(found)
    if node.status is INVALID:
        return found
    try:
        halt_alone(node, reason, seen)
    except Raised as raised:
        found.append(raised)
    return found
