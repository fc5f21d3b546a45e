"""Who is told what happens during a run, and what becomes of one that raises."""

from __future__ import annotations

from typing import Any

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Level
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree


class Listener:
    """Who is told what happens during a run; a subclass does something about it."""

    def node_changed(self, change: NodeChange) -> None:
        """A node's status changed."""

    def event(self, time: float, level: Level, text: str) -> None:
        """Something else happened."""

    def progress(self, time: float, running: str) -> None:
        """A tick is over; ``running`` is the deepest running node and what it says."""

    def show(self, tree: Tree) -> None:
        """Another tree takes the place of the one that ran."""


def listening(listener: Listener) -> Listener:
    """Return a listener that can be told everything.

    Raises:
        UserError: it lacks a method.
    """
    methods = [name for name in vars(Listener) if not name.startswith("_")]
    if missing := [name for name in methods if not callable(getattr(listener, name, None))]:
        message = f"'listener' has no {', '.join(f'{name}()' for name in missing)}: {listener!r}"
        raise UserError(message, hint="derive it from Listener, whose methods do nothing")
    return listener


class Guarded(Listener):
    """Passes on to a listener what it is told until that raises, so that the run goes on to a proper end.

    Args:
        listener: who is told.

    Attributes:
        failure: what it raised, None while it has not.
    """

    def __init__(self, listener: Listener) -> None:
        self._listener = listener
        self.failure: Exception | None = None

    @property
    def hears_progress(self) -> bool:
        """Whether it does something about a tick that is over: else nobody need put into words what runs."""
        return getattr(self._listener.progress, "__func__", None) is not Listener.progress

    def node_changed(self, change: NodeChange) -> None:
        """A node's status changed."""
        self._tell("node_changed", change)

    def event(self, time: float, level: Level, text: str) -> None:
        """Something else happened."""
        self._tell("event", time, level, text)

    def progress(self, time: float, running: str) -> None:
        """A tick is over."""
        self._tell("progress", time, running)

    def show(self, tree: Tree) -> None:
        """Another tree takes the place of the one that ran."""
        self._tell("show", tree)

    def _tell(self, method: str, *what: Any) -> None:
        if self.failure is None:
            try:
                getattr(self._listener, method)(*what)
            except Exception as error:
                self.failure = error
