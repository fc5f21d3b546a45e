"""Places for nodes besides children: a watchdog's ``on_stale``, the ``then`` of an ``if``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Takes = Literal["many", "one", "none"]
"""How many children a node type has: a list of them, one beside the parameters, or none."""


@dataclass(frozen=True)
class Slot:
    """A place for a node.

    Its class takes the node as a keyword argument of the slot's name, with ``_`` behind a Python keyword (``else_``);
    a slot for ``many`` as a mapping of names to nodes.

    Attributes:
        doc: one line.
        required: whether it must be given.
        condition: text in it is an expression.
        many: it holds a mapping of names to nodes (the ``cases`` of a ``switch``).
    """

    doc: str
    required: bool = False
    condition: bool = False
    many: bool = False
