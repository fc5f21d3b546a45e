"""Ticking a tree: one snapshot in, one command out, and every change of a node's status told."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core import forks
from humanoid_bt.core.ctrl_c import is_ctrl_c
from humanoid_bt.core.errors import HumanoidBtError, Place, Problem, ResourceConflict, UserError
from humanoid_bt.core.messages import Command, Percept, State
from humanoid_bt.core.texts import shortened, told
from humanoid_bt.decision.overridden import not_set_up
from humanoid_bt.decision.result import Reported, reported
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.skill import Skill
from humanoid_bt.files.class_files import class_file, method_place, place_in_file
from humanoid_bt.tree.counting import tally
from humanoid_bt.tree.node import Node
from humanoid_bt.tree.ticking.catching import Catcher, catch
from humanoid_bt.tree.ticking.counted import Counted
from humanoid_bt.tree.ticking.tick import INVALID, RUNNING, End, Raised, Seen, StatusError, halt_alone, tick
from humanoid_bt.tree.tree import Tree


@dataclass(frozen=True, slots=True)
class NodeChange:
    """A node's status changed, or the node has come to it once more.

    That is a skill that was started anew and ended at once as it had the last time, or any node that was started and
    halted in one tick, or raised an exception in it.

    Of a skill that ended and was reset in one tick there are two.

    Attributes:
        time: engine time of the tick [s].
        path: the node's path.
        status: its new status; INVALID when it was halted, or reset because its branch was left.
        feedback: what the node says about it; of one that was halted why, and nothing of one that was reset.
        results: of a skill that has ended, or was halted: what it had set by then.
    """

    time: float
    path: str
    status: Status
    feedback: str
    results: tuple[Reported, ...] = ()


class NodeError(HumanoidBtError):
    """A node raised an exception.

    Attributes:
        path: the node's path.
        place: where the node stands in its tree file.
        error: the exception.
        where: the line of the skill's file that raised it, or where its ``update`` begins that returned no status; None
            if it came from elsewhere.
    """

    def __init__(self, node: Node, error: BaseException) -> None:
        self.path = node.path
        self.place: Place = node.place
        self.error = error
        self.where = _where(node.type.cls, error) if node.kind == "skill" else None  # the engine's lines tell nothing
        what = "its update is" if isinstance(error, StatusError) else "raised"
        at = f"\n    {what} at {self.where}" if self.where else ""
        super().__init__(f"{self.place}: the node {self.path!r} raised {told(error)}{at}")


def _where(cls: type, error: BaseException) -> Place | None:
    if isinstance(error, StatusError):
        return method_place(next(base for base in cls.__mro__ if "update" in vars(base)), "update")
    file = class_file(cls)
    return place_in_file(error, file) if file else None


class Executor:
    """Runs one tree on one robot.

    Args:
        tree: the tree.
        robot: the robot as decision sees it.
        on_change: called after a tick or halt for every node whose status differs from before it, or that has come to
            it once more; children before parents, in the order in which they were ticked or halted. How skills ended
            that were reset in the same tick comes before all of this.
    """

    def __init__(self, tree: Tree, robot: Robot, on_change: Callable[[NodeChange], None] | None = None) -> None:
        self.tree = tree
        self._root = tree.root
        self.robot = robot
        self._on_change = on_change
        self._nodes: dict[Behaviour, Node] = {node.behaviour: node for node in tree.nodes}
        self._children_first = [behaviour for behaviour in tree.root.iterate() if behaviour in self._nodes]
        self._skills = frozenset(node.behaviour for node in tree.nodes if node.kind == "skill")
        self._commanding: dict[Behaviour, Skill] = {skill: skill for skill in self._skills if isinstance(skill, Skill)}
        self._told: dict[Behaviour, Status] = dict.fromkeys(self._nodes, INVALID)
        self._tally = tally(tree)
        self._caught: dict[Behaviour, tuple[str, int]] = {}  # what was taken of a node last, and how often in a row
        for node in tree.nodes:
            if isinstance(node.behaviour, Catcher):
                node.behaviour.on_caught = partial(self._tell_caught, node)

    @property
    def status(self) -> Status:
        """The root's status; INVALID before the first tick and after a halt."""
        return self._root.status

    def setup(self) -> None:
        """Give every node the robot; called once, before the first tick.

        Raises:
            UserError: with everything that nodes did not find (a percept, a hand, a joint).
            NodeError: a node raised another exception.
        """
        problems: list[Problem] = []
        for behaviour in self._children_first:
            node = self._nodes[behaviour]
            own = [behaviour] if node.kind != "skill" else list(behaviour.iterate())  # a leaf may hide children
            try:
                for inner in own:
                    inner.setup(robot=self.robot)
                    if (problem := not_set_up(inner)) and problem not in problems:
                        problems.append(problem)
            except UserError as error:
                problems += [replace(p, place=p.place or node.place) for p in error.problems]
            except BaseException as error:
                if is_ctrl_c(error):
                    raise
                raise NodeError(node, error) from error
        if problems:
            raise UserError(problems)

    def tick(self, state: State, percepts: Mapping[str, Percept]) -> Command:
        """Tick the tree once on a snapshot and return what it commands.

        A tree that has ended starts again, its blackboard too.

        Raises:
            NodeError: a node raised an exception or returned what is no status; the whole tree has been halted.
            ResourceConflict: two living nodes command one resource; the whole tree has been halted.
        """
        forks.astray = False
        self.robot.begin_tick(state, percepts)
        if self._root.status is not RUNNING:
            for key in self.tree.keys:
                key.reset()
        seen = self._seen()
        try:
            tick(self._root, seen)
            command = self.robot.commit()
        except Raised as raised:
            node = self._nodes[raised.node]
            self._halt_all(f"{raised.node.name!r} raised an exception", seen)
            self._tell(seen, state.time)
            raise NodeError(node, raised.error) from raised.error
        except ResourceConflict as conflict:
            self._halt_all(str(conflict), seen)
            self._tell(seen, state.time)
            raise
        if seen.changed:
            self._tell(seen, state.time)
        return command

    def halt(self, reason: str) -> None:
        """Halt the whole tree, children before parents.

        Args:
            reason: why, told to the skills.

        Raises:
            NodeError: a node raised an exception while it was halted; the others have been halted all the same.
        """
        seen = self._seen()
        raised = self._halt_all(reason, seen)
        self._tell(seen, self.robot.now)
        if raised is not None:
            raise NodeError(self._nodes[raised.node], raised.error) from raised.error

    def _seen(self) -> Seen:
        seen = Seen() if self._tally is None else Counted(self._tally)
        seen.skills, seen.commanding = self._skills, self._commanding
        return seen

    def _halt_all(self, reason: str, seen: Seen) -> Raised | None:
        """Halt every node, whatever state an interrupted tick left them in; return the first exception not caught."""
        first: Raised | None = None
        for behaviour in self._children_first:
            try:
                if behaviour.status is not INVALID:
                    halt_alone(behaviour, reason, seen)
            except Raised as raised:
                if not catch(raised):
                    first = first or raised
        return first

    def _tell_caught(self, by: Node, raised: Raised) -> None:
        """Tell that an ``on_error`` made a failure of an exception; of a node's same one the 1st, 10th ... time."""
        text = str(NodeError(self._nodes[raised.node], raised.error)).replace("\n    ", ", ")
        before, times = self._caught.get(raised.node, ("", 0))
        times = times + 1 if text == before else 1
        self._caught[raised.node] = text, times
        if times == 10 ** (len(str(times)) - 1):
            again = f" for the {times:,}th time" if times > 1 else ""
            self.robot.log(by.path, "warning", f"caught{again}: {text}")

    def _tell(self, seen: Seen, time: float) -> None:
        told = self._told
        for behaviour, end in seen.ends.items():
            if told[behaviour] is not end.status or behaviour in seen.once_more:
                self._tell_one(behaviour, time, end)
        for behaviour in reversed(dict.fromkeys(reversed(seen))):  # where it stands for the last time
            status = behaviour.status
            reset = status is INVALID and not behaviour.feedback_message  # what was halted or raised says so
            once_more = not reset if status is INVALID else behaviour in seen.once_more
            if once_more or told[behaviour] is not status:
                results = () if status is RUNNING or reset else reported(behaviour)
                self._tell_one(behaviour, time, End(status, behaviour.feedback_message, results))

    def _tell_one(self, behaviour: Behaviour, time: float, now: End) -> None:
        self._told[behaviour] = now.status
        if self._on_change is not None:
            path = self._nodes[behaviour].path
            self._on_change(NodeChange(time, path, now.status, shortened(now.feedback), now.results))
