"""What a program does with a run to find out why its tree does what it does: pausing, breakpoints, setting, forcing."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Pause
from humanoid_bt.session.drive import Drive


class Debugging:
    """A run that can be paused and changed; what is done to it is told and recorded."""

    _drive: Drive

    @property
    def paused(self) -> Pause | None:
        """Who paused the run, and why; None while it goes on."""
        return None if self._drive.end else self._drive.debugger.pause

    def pause(self, reason: str = "asked for by the program", *, source: str = "program") -> None:
        """Let the tree stand still from the next tick on, and control hold the robot. From any thread.

        Raises:
            HumanoidBtError: the session has been left.
        """
        self._not_left("paused")
        self._drive.debugger.ask_pause(source, reason)

    def resume(self, *, source: str = "program") -> None:
        """Let a paused tree go on with its next tick. From any thread."""
        self._drive.debugger.resume(source)

    def break_at(self, what: str) -> None:
        """Pause the run, after the tick, where something happens.

        Args:
            what: a node, by its path or the end of it: when it starts; ``reach=FAILURE``: when it gets that status,
                RUNNING, SUCCESS, FAILURE or HALTED; or an expression as in a condition: when it becomes true. A node
                that is no skill and ends in the tick in which it starts counts when its result is another than the
                last time.

        Raises:
            UserError: it names no node of the tree, and is no expression either.
        """
        self._drive.debugger.break_at(what, self._drive.runner.tree, self._drive.engine.publishes)

    @property
    def breakpoints(self) -> tuple[str, ...]:
        """Where the run pauses, as it was given to :meth:`break_at`."""
        return tuple(point.text for point in self._drive.debugger.breakpoints)

    def clear_breakpoints(self) -> None:
        """Pause nowhere by itself any more."""
        self._drive.debugger.breakpoints.clear()

    def set(self, name: str, value: Any, *, source: str = "program") -> None:
        """Set a key of the blackboard or a parameter, between two steps; the run tells who did.

        Args:
            name: of a key; ``reach.timeout``: of a parameter of a node; or of a parameter of the tree, set wherever
                a node is given it as ``$name``.
            value: plain, in SI units, or text as after ``--set``, "5 s".

        Raises:
            UserError: there is none of this name, it takes no such value, or it must be known before the run.
            HumanoidBtError: the session has been left.
        """
        self._not_left("set")
        self._drive.debugger.assign(self._drive.runner.tree, name, value, source)

    def force(self, path: str, status: Status | str, *, source: str = "program") -> None:
        """Let the next tick of a node give a result, once, whatever it would do; what runs below it is halted then.

        Args:
            path: the node's, or the end of it.
            status: SUCCESS or FAILURE.

        Raises:
            UserError: there is no such node, or that is no result.
            HumanoidBtError: the session has been left.
        """
        self._not_left("forced")
        self._drive.debugger.force(self._drive.runner.tree, path, status, source)

    def between_ticks(self, action: Callable[[], None]) -> None:
        """Do something before the next tick, in the thread that steps. From any thread.

        A :class:`UserError` that it raises is told as an event of the run, which goes on.
        """
        self._drive.debugger.ask(action)

    def request_step(self, *, source: str = "program") -> None:
        """Let a paused tree that another thread runs have one tick; pause it if it goes on. From any thread."""
        self._drive.debugger.ask_step(source)

    def _not_left(self, what: str) -> None:
        if self._drive.report is not None:
            raise HumanoidBtError(
                f"the session of {self._drive.runner.tree.name!r} has been left: nothing can be {what} any more"
            )
