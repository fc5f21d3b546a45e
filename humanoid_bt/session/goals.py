"""Goals from outside: each lets the tree run once, with parameters of its own, while the run goes on."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from humanoid_bt.core.errors import HumanoidBtError, Problem, UserError
from humanoid_bt.core.texts import shortened
from humanoid_bt.session.edits import Edit, EditSource
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.loader import TreeLoader
from humanoid_bt.session.outcome import End
from humanoid_bt.session.teller import Teller
from humanoid_bt.session.tree_runner import TreeRunner
from humanoid_bt.tree.ticking.executor import Executor, NodeError
from humanoid_bt.tree.tree import Tree

_CANCELED = "the goal was canceled"
_LONGEST = 500  # characters of why a goal ended: a message that is too long would not arrive


@dataclass(frozen=True)
class GoalTree(Edit):
    """The tree of a goal, or what is wrong with it.

    Attributes:
        goal: which.
    """

    goal: str = ""


class GoalTrees:
    """Loads the tree of each goal, in another thread than that of the ticks.

    Args:
        loader: loads the tree.
        prepare: sets it up on the robot.

    Attributes:
        orders: the goals that came: the identity of each, and the parameters that it gives.
    """

    def __init__(self, loader: TreeLoader, prepare: Callable[[Tree], Executor]) -> None:
        self._loader, self._prepare = loader, prepare
        self.orders: deque[tuple[str, Mapping[str, Any]]] = deque()

    def poll(self) -> GoalTree | None:
        """Return the tree of the next goal, or what is wrong with it; None without a goal."""
        if not self.orders:
            return None
        goal, parameters = self.orders.popleft()
        try:
            return GoalTree((), self._prepare(self._loader.reload(parameters)), goal=goal)
        except UserError as error:
            return GoalTree((), problems=error.problems, goal=goal)
        except NodeError as error:
            return GoalTree((), problems=(Problem(str(error)),), goal=goal)


class Goals:
    """Starts the tree when a goal comes, and holds the robot between two goals. To be asked between two ticks.

    Args:
        engine: where goals come from, and which is told how they end.
        trees: takes their parameters.
        ready: where their trees come from.
        runner: what runs the tree.
        teller: is told what happens.
    """

    def __init__(self, engine: Engine, trees: GoalTrees, ready: EditSource, runner: TreeRunner, teller: Teller) -> None:
        self._engine, self._trees, self._ready, self._runner, self._teller = engine, trees, ready, runner, teller
        self._goal, self._waits = "", False  # the one that is at work; whether its tree is not ready yet
        teller.resting = "waiting for a goal"
        runner.rest(End("unfinished", "no goal has come"))

    def look(self) -> None:
        """Take orders, start the tree of a goal that is ready, tell of one that has ended."""
        if self._goal and (end := self._runner.ended) is not None and not self._waits:
            self._ended(end)
        for order in self._engine.take_orders():
            if order["order"] == "start":
                self._goal, self._waits = order["goal"], True
                self._trees.orders.append((self._goal, order["parameters"]))
            elif self._goal and order["goal"] in (self._goal, ""):
                self._cancel()
        ready = self._ready.poll()
        if isinstance(ready, GoalTree) and self._waits and ready.goal == self._goal:  # else it was canceled meanwhile
            self._waits = False
            self._start(ready)

    def _start(self, ready: GoalTree) -> None:
        if ready.executor is None:
            why = "; ".join(problem.message for problem in ready.problems if problem.severity == "error")
            self._teller.event("error", f"a goal has come that cannot be: {why}")
            self._ended(End("error", why))
            return
        self._runner.replace(ready.executor)
        self._teller.event("info", "a goal has come: the tree starts")
        self._teller.show(ready.executor.tree)

    def _cancel(self) -> None:
        if not self._waits and self._runner.ended is None:
            try:
                self._runner.halt(_CANCELED)
            except HumanoidBtError as error:  # all of the tree has been halted all the same
                self._teller.event("error", str(error))
            self._runner.rest(End("interrupted", _CANCELED), self._teller.now)
            self._teller.tree_ended("interrupted", f": {_CANCELED}; {self._teller.resting}")
        self._waits = False
        self._ended(End("interrupted", _CANCELED))

    def _ended(self, end: End) -> None:
        said = {"goal": self._goal, "outcome": end.outcome, "reason": shortened(end.reason, _LONGEST)}
        self._engine.announce("goal", {"time": self._teller.now, **said})
        self._goal = ""
