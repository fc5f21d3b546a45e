"""The course of a run: what can be asked about it from outside, beside what its tree can ask."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple, Protocol

from py_trees.common import Status

from humanoid_bt.control.supervisor import Stop
from humanoid_bt.core.errors import HumanoidBtError, Place
from humanoid_bt.core.messages import Mode, State
from humanoid_bt.decision.result import ResultValue
from humanoid_bt.decision.robot import Robot
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree

_ENDS = {Status.SUCCESS: "succeeded", Status.FAILURE: "failed"}


class NoValue(HumanoidBtError):  # noqa: N818 (the name says it)
    """Something was asked that has no value yet: how a run ended that goes on, a result that nothing has reported."""


class View(Protocol):
    """A run after a tick."""

    robot: Robot
    statuses: dict[str, Status]

    @property
    def time(self) -> float:
        """Engine time of the tick [s]."""

    @property
    def state(self) -> State:
        """What the tick saw of the robot."""

    @property
    def changes(self) -> Sequence[NodeChange]:
        """The nodes whose status the tick changed."""

    @property
    def results(self) -> Mapping[str, Mapping[str, ResultValue]]:
        """What the skills that ran in it have reported by then: path -> name -> value, in SI units."""

    @property
    def touched(self) -> Sequence[str]:
        """Names of the scene's objects that the robot has touched by then."""

    @property
    def bumped(self) -> Sequence[str]:
        """Names of those of them that it touched without a hand having been sent there."""


class Missed(NamedTuple):
    """An event of a run's script that never happened.

    Attributes:
        event: its moment and what it would have done.
        place: where it is written.
        optional: whether that may be so.
        values: what its moment asks, and the values at the end, as people read them.
    """

    event: str
    place: Place
    optional: bool
    values: Mapping[str, str]


class Run(Protocol):
    """A run that is over."""

    @property
    def tree(self) -> Tree:
        """What ran."""

    @property
    def stops(self) -> Sequence[Stop]:
        """Every stop the supervisor ordered."""

    @property
    def missed(self) -> Sequence[Missed]:
        """The events of its script that never happened."""

    @property
    def outcome(self) -> str:
        """How it ended."""

    @property
    def reason(self) -> str:
        """Why, in words."""

    @property
    def time(self) -> float:
        """Simulated time from the first tick until the tree ended [s]."""

    @property
    def fell(self) -> bool:
        """Whether the robot fell, also if that was after the tree had ended."""

    def views(self) -> Iterator[View]:
        """Yield it after each tick."""


class End(NamedTuple):
    """How a run ended: the outcome, as in its report, and why."""

    outcome: str
    reason: str


class Life:
    """What one node did so far.

    Args:
        node: the node.

    Attributes:
        ran: whether it ever had its turn.
        begins: whether its turn began in this tick.
        ended: how it ended last: succeeded, failed, halted; "" before that, and while it runs.
        feedback: what it said as it began, or ended, whichever came last.
        changed_at: when that was: the time [s], and its place among the changes of the tick.
        results: what it has reported since it began last.
    """

    def __init__(self, node: Node) -> None:
        self.node = node
        self.ran = self.begins = False
        self.ended = self.feedback = ""
        self.changed_at = (-1.0, 0)
        self.results: Mapping[str, ResultValue] = {}
        self._status = Status.INVALID

    @property
    def runs(self) -> bool:
        """Whether it runs."""
        return self._status is Status.RUNNING

    @property
    def said(self) -> str:
        """What it does, or how it ended last and what it said then."""
        does = "runs" if self.runs else self.ended or "never ran"
        return does if self.runs or not self.feedback else f"{does}: {self.feedback.removeprefix('halted: ')}"

    def look(self, view: View) -> None:
        """Look at the node after a tick."""
        self.begins = False
        for index, change in enumerate(view.changes):
            if change.path == self.node.path:
                self._follow(change, (view.time, index))
        self.results = view.results.get(self.node.path) or self.results

    def _follow(self, change: NodeChange, at: tuple[float, int]) -> None:
        before, now = self._status, change.status
        self._status = now
        if now is Status.INVALID and before is not Status.RUNNING and not change.feedback:
            return  # it had ended before, and is only reset
        if before is not Status.RUNNING:
            self.begins, self.results = True, {}
        self.ran = True
        self.ended = "" if now is Status.RUNNING else _ENDS.get(now, "halted")
        self.feedback, self.changed_at = change.feedback, at


class Course:
    """What a run has come to so far, as it is told tick by tick.

    Args:
        tree: what runs.
        stops: the stops of the run; later ones may be among them.

    Attributes:
        tree: what runs.
        time: since the run began [s].
        mode: what the supervisor allows.
        fell: whether the robot fell.
        touched: names of the scene's objects that the robot has touched.
        bumped: names of those that it touched without a hand having been sent there.
    """

    def __init__(self, tree: Tree, stops: Sequence[Stop] = ()) -> None:
        self.tree = tree
        self.time = 0.0
        self.mode = Mode.RUN
        self.fell = False
        self.touched: Sequence[str] = ()
        self.bumped: Sequence[str] = ()
        self._stops = stops
        self._robot: Robot | None = None
        self._began: float | None = None
        self._end: End | None = None
        self._lives: dict[str, Life] = {}  # of the nodes that somebody asks about

    def tick(self, view: View) -> None:
        """Look at what a tick has brought."""
        self._began = view.time if self._began is None else self._began
        self.touched, self.bumped = view.touched, view.bumped
        self.time, self.mode, self._robot = view.time - self._began, view.state.mode, view.robot
        self.fell = self.fell or self.mode is Mode.DAMP
        for life in self._lives.values():
            life.look(view)

    def finish(self, run: Run) -> None:
        """Take how the run ended; what nodes did last stays as it was before they were halted for that."""
        self._end, self.fell = End(run.outcome, run.reason), run.fell
        self.time = max(self.time, run.time)
        for life in self._lives.values():
            life.begins = False

    @property
    def robot(self) -> Robot:
        """The robot as the last tick saw it.

        Raises:
            NoValue: there was no tick.
        """
        if self._robot is None:
            raise NoValue("the run ended before its first tick")
        return self._robot

    @property
    def stops(self) -> int:
        """How many stops the supervisor has ordered so far."""
        if self._end is not None:
            return len(self._stops)
        now = self.time + (self._began or 0.0) + 1e-9  # engine times are sums of floats
        return sum(stop.time <= now for stop in self._stops)

    @property
    def end(self) -> End:
        """How the run ended.

        Raises:
            NoValue: it goes on.
        """
        if self._end is None:
            raise NoValue("the run goes on")
        return self._end

    def nodes(self, name: str) -> list[Node]:
        """Return the nodes of a name: those whose path ends with it, else those of this type."""
        found = [node for node in self.tree.nodes if f"/{node.path}".endswith(f"/{name}")]
        return found or [node for node in self.tree.nodes if node.type_name == name]

    @property
    def node_names(self) -> set[str]:
        """The names by which there are nodes, for hints."""
        return {name for node in self.tree.nodes for name in (node.name, node.type_name)}

    def lives(self, nodes: Sequence[Node]) -> list[Life]:
        """Return what nodes do, from the next tick on."""
        return [self._lives.setdefault(node.path, Life(node)) for node in nodes]

    def result(self, name: str, lives: Sequence[Life]) -> ResultValue:
        """Return what was reported under a name: by the node that runs, else by the one that ended last.

        Raises:
            NoValue: none of the nodes has reported it.
        """
        having = [life for life in lives if name in life.results]
        if not having:
            raise NoValue(f"nothing has reported {name!r} yet")
        return _latest(having).results[name]

    def feedback(self, lives: Sequence[Life]) -> str:
        """Return what the node said that runs, else what the one said that ended last."""
        return _latest(lives).feedback

    def reporting(self, name: str) -> list[Node]:
        """Return the nodes that declare a result."""
        return [node for node in self.tree.nodes if name in node.type.results]

    @property
    def results(self) -> Iterator[str]:
        """The name of every result that a node declares, for hints."""
        for node in self.tree.nodes:
            yield from node.type.results


def _latest(lives: Sequence[Life]) -> Life:
    """Return the one that runs, of several the one that began last, else the one that ended last."""
    return max(lives, key=lambda life: (life.runs, life.changed_at))
