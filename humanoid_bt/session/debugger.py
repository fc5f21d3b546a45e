"""Standing still between two ticks: who paused a run, and what may go on."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection
from typing import Any

from py_trees.common import Status

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import Pause
from humanoid_bt.core.plain import plain
from humanoid_bt.core.texts import shortened
from humanoid_bt.session.breakpoints import Breakpoint, breakpoint_at
from humanoid_bt.session.setting import setting
from humanoid_bt.session.teller import Teller
from humanoid_bt.session.tree_runner import TreeRunner
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.ticking.forcing import force
from humanoid_bt.tree.tree import Tree

_HOW_TO_GO_ON = "; c continues, n is one tick, : takes commands"
_RESULTS = {status.name: status for status in (Status.SUCCESS, Status.FAILURE)}


class Debugger:
    """Says before every tick of one run whether the tree may have it, and after it whether it stands still.

    What is asked for holds at once, from any thread; it is told, as an event, when the run comes to it.

    Args:
        teller: is told who did what.

    Attributes:
        teller: is told who did what.
        pause: who wants the tree to stand still, and why; None while it goes on.
        breakpoints: where it pauses by itself.
        attended: whether a person is there to continue it: simulated time goes on at the pace of real time meanwhile.
    """

    def __init__(self, teller: Teller) -> None:
        self.teller = teller
        self.pause: Pause | None = None
        self.attended = False
        self.breakpoints: list[Breakpoint] = []
        self._statuses: dict[str, Status] = {}  # of the nodes that have changed, while there are breakpoints
        self._tree: Tree | None = None  # in which they were looked up
        self._steps: deque[str] = deque()  # who wants a paused tree to have a tick
        self._news: deque[str] = deque()
        self._actions: deque[Callable[[], None]] = deque()

    def ask_pause(self, source: str, reason: str) -> None:
        """Let the tree stand still from the next tick on; who asked first stays the one who did."""
        if self.pause is None:
            self.pause = pause = Pause(shortened(source), shortened(reason))
            self._news.append(f"{pause}{_HOW_TO_GO_ON if self.attended else ''}")

    def resume(self, source: str) -> None:
        """Let the tree go on."""
        if self.pause is not None:
            self.pause = None
            self._steps.clear()
            self._news.append(f"continued by {source}")

    def ask_step(self, source: str) -> None:
        """Let a paused tree have one tick; one that goes on is paused."""
        if self.pause is None:
            self.ask_pause(source, "to go on step by step")
        else:
            self._steps.append(source)

    def stepped(self, source: str) -> None:
        """Take note that a paused tree has a tick."""
        self._news.append(f"one tick by {source}")

    def standing(self) -> Pause | None:
        """Return why there is no tick now, None if there is one; it takes a step that was asked for."""
        if self._steps and self.pause is not None:
            self.stepped(self._steps.popleft())
            return None
        return self.pause

    def ask(self, action: Callable[[], None]) -> None:
        """Do something between two ticks, in the thread that ticks."""
        self._actions.append(action)

    def assign(self, tree: Tree, name: str, value: Any, source: str) -> None:
        """Set a key or a parameter, between two ticks; raises as :func:`setting`."""
        self._news.append(f"set {setting(tree, name, value).apply()} by {source}")
        self.teller.given("set", [name, plain(value)])

    def force(self, tree: Tree, path: str, status: Status | str, source: str) -> None:
        """Let the next tick of a node give a result; between two ticks.

        Raises:
            UserError: there is no such node or result.
        """
        node = tree.node(path)
        if (result := _RESULTS.get(str(getattr(status, "name", status)).upper())) is None:
            message = f"the result of a node cannot be {status!r}"
            raise UserError(message, hint=f"valid: {', '.join(_RESULTS)}", code="wrong-choice")
        force(node.behaviour, result, why := f"forced to {result.name} by {source}")
        self._news.append(f"forced {node.path} to {result.name} by {source}")
        self.teller.given("force", [node.path, result.name, why])

    def break_at(self, text: str, tree: Tree, percepts: Collection[str]) -> None:
        """Add a breakpoint; raises as :func:`breakpoint_at`."""
        if not self.breakpoints:
            self._tree, self._statuses = tree, {node.path: node.status for node in tree.nodes}
        self.breakpoints.append(breakpoint_at(text, tree, percepts))

    def node_changed(self, change: NodeChange) -> None:
        """Take what a tick changed: it may be at a breakpoint."""
        if self.breakpoints:
            before = self._statuses.get(change.path, Status.INVALID)
            self._statuses[change.path] = change.status
            self._break(lambda point: point.changed(change, before))

    def ticked(self, runner: TreeRunner) -> None:
        """Look after a tick whether it is at a breakpoint."""
        if self.breakpoints:
            if self._tree is not runner.tree:
                self._find_anew(runner.tree)
            self._break(lambda point: point.ticked(runner.robot))

    def _break(self, hit: Callable[[Breakpoint], Pause | None]) -> None:
        for point in self.breakpoints:
            if (pause := hit(point)) is not None:
                self.ask_pause(pause.source, pause.reason)

    def _find_anew(self, tree: Tree) -> None:
        """Look breakpoints up in an edited tree, which may not have what they name."""
        self._tree = tree
        for point in list(self.breakpoints):
            try:
                point.find(tree)
            except UserError as error:
                self.breakpoints.remove(point)
                self.teller.event("warning", f"the breakpoint at {point.text} is gone: {error.problems[0].message}")

    def tell(self) -> None:
        """Do and tell what was asked for since the last time."""
        while self._news or self._actions:
            while self._news:
                self.teller.event("info", self._news.popleft())
            if self._actions:
                self._do(self._actions.popleft())

    def _do(self, action: Callable[[], None]) -> None:
        """Do what was asked for; nobody waits for it who could be told of a mistake."""
        try:
            action()
        except UserError as error:
            self.teller.event("error", "; ".join(problem.message for problem in error.problems))
