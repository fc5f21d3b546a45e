"""Calls: what a tree asks of other programs, and what it hears back. Nothing in decision waits for an answer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, Protocol

from humanoid_bt.core.errors import Place

UNKNOWN: Any = None
"""What stands in a request, when it is checked before the run, for a value that is only known while the tree runs."""


@dataclass(frozen=True)
class Call:
    """What is asked.

    Attributes:
        kind: a service answers once, an action is worked on for a while.
        name: of the service or the action.
        type: its type, such as std_srvs/SetBool.
        request: the fields of the request, or of the goal, as data for JSON.
        reads: the fields of the response, or of the result, that are wanted: each by its path, ``pose.position.x``.
        success: path of one that must be true; "" for ``success``, if there is one.
        feedback: path of the field of an action's feedback that is told; "" for none.
    """

    kind: Literal["service", "action"]
    name: str
    type: str
    request: Mapping[str, Any] = field(default_factory=dict)
    reads: tuple[str, ...] = ()
    success: str = ""
    feedback: str = ""


@dataclass(frozen=True)
class Answer:
    """What is known of a call.

    Attributes:
        state: pending while nobody has taken it, running while somebody works on it, else how it ended.
        text: what there is to say about it.
        values: of the fields that were wanted, once it has succeeded.
    """

    state: Literal["pending", "running", "success", "failure"]
    text: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def final(self) -> bool:
        """Whether nothing more comes."""
        return self.state in ("success", "failure")


class Calls(Protocol):
    """What carries calls to other programs."""

    def check(self, call: Call, places: Mapping[str, Place]) -> None:
        """Refuse what nobody could answer.

        Args:
            call: it; a value that is not known yet is :data:`UNKNOWN`, every other one has its type.
            places: path of a field of the request -> where it is written.

        Raises:
            UserError: the type is not installed, or has no such field, or one of another type.
        """

    def ask(self, call: Call) -> int:
        """Ask; return the call's number."""

    def answer(self, number: int) -> Answer:
        """Return what is known of a call."""

    def drop(self, number: int) -> None:
        """Be done with a call: its answer is not wanted any more; a goal that is at work is canceled."""
