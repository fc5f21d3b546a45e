"""How nodes are ticked and halted: one function each, the same for every kind of node.

Nodes are plain py_trees behaviours. Those of this package decide in :meth:`Branch.advance`, by plain calls and not
by generators, and note every node they touch in ``seen``, children before parents; py_trees' own way to tick
(``tick``, ``tick_once``, visitors) still works on them. Leaves of any origin are ticked as py_trees does it.
"""

from __future__ import annotations

import abc
from collections.abc import Collection, Iterator, Mapping
from typing import NamedTuple

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.core import forks
from humanoid_bt.core.ctrl_c import is_ctrl_c
from humanoid_bt.core.texts import shortened, told
from humanoid_bt.decision.arguments import check_relative
from humanoid_bt.decision.result import Reported, reported
from humanoid_bt.decision.skill import Skill


class End(NamedTuple):
    """How a skill ended that was reset later in the same tick.

    Attributes:
        status: SUCCESS or FAILURE.
        feedback: what it said.
        results: what it had set.
    """

    status: Status
    feedback: str
    results: tuple[Reported, ...]


class Seen(list[Behaviour]):
    """Nodes ticked or halted so far, children before parents; a node may stand in it twice.

    Attributes:
        changed: whether any of them has another status than before, or has come to it once more.
        skills: nodes of which is told each time that they end.
        commanding: those of them that command the robot as skills of this package do, each as what it is.
        once_more: those of them that were started anew and have ended as they had before; not if only asked again.
        ends: how those of them ended that were reset after they had been ticked.
    """

    changed = False
    skills: Collection[Behaviour] = ()
    commanding: Mapping[Behaviour, Skill] = {}
    once_more: Collection[Behaviour] = ()
    ends: Mapping[Behaviour, End] = {}


SUCCESS, FAILURE, RUNNING, INVALID = Status.SUCCESS, Status.FAILURE, Status.RUNNING, Status.INVALID


class Raised(Exception):  # noqa: N818 (it carries an error, it is none)
    """Carries an exception and the node that raised it up through the tree."""

    def __init__(self, node: Behaviour, error: BaseException) -> None:
        super().__init__(node, error)
        self.node = node
        self.error = error


class StatusError(TypeError):
    """What a node's ``update`` returned is no status."""


class Branch(Behaviour):
    """Base of the nodes with children; a subclass decides its status in :meth:`advance`."""

    @abc.abstractmethod
    def advance(self, seen: Seen) -> Status:
        """Tick and halt children as this node does and return its status. No child runs on when it ends.

        Before it, ``initialise`` is called whenever the node is not RUNNING.
        """

    def asks_again(self, child: Behaviour) -> bool:
        """Return whether a child that has ended and is ticked while this node runs is only asked again, not started."""
        return True

    def halt_child(self, child: Behaviour, reason: str, seen: Seen) -> None:
        """Halt a child: this node is being halted; raises as :func:`halt`."""
        halt(child, reason, seen)

    def update(self) -> Status:
        """Not used: :meth:`advance` decides."""
        return self.status

    def tick(self) -> Iterator[Behaviour]:
        """Tick the branch as py_trees does, and yield the nodes ticked, children before parents."""
        seen = Seen()
        forks.astray = False
        try:
            tick(self, seen)
        except Raised as raised:
            raise raised.error from None
        yield from seen

    def stop(self, new_status: Status = INVALID) -> None:
        """Halt what runs below, children before parents, and take the status."""
        for child in self.children:
            if child.status is RUNNING or (new_status is INVALID and child.status is not INVALID):
                halt(child, f"{self.name!r} was stopped", Seen())
        self.terminate(new_status)
        self.status = new_status


_BRANCH_TICK, _LEAF_TICK = Branch.tick, Behaviour.tick


def tick(node: Behaviour, seen: Seen) -> Status:
    """Tick one node and return its status.

    Raises:
        Raised: a node raised an exception, or returned what is no status. That node has been told to stop.
    """
    how, before = type(node).tick, node.status
    leaf = how is _LEAF_TICK
    try:
        if leaf or how is _BRANCH_TICK:
            if before is not RUNNING:
                node.feedback_message = ""
                node.initialise()
            status: Status = node.update() if leaf else node.advance(seen)  # type: ignore[attr-defined]  # a Branch
        else:
            status = _own_tick(node)
        if status is RUNNING and (skill := seen.commanding.get(node)) is not None:
            check_relative(skill.robot.targets)
        if forks.astray or (status is not RUNNING and status is not SUCCESS and status is not FAILURE):
            raise _no_status(node, status)
    except Raised:
        raise
    except BaseException as error:  # a skill that exits or is cancelled must not take the robot's program along
        _check_own(error)
        _abandon(node, error, seen)
        raise Raised(node, error) from error
    if leaf and status is not RUNNING:
        try:
            node.stop(status)
        except BaseException as error:
            raise _not_stopped(node, error, seen) from error
    node.status = status
    seen.append(node)
    if status is not before:
        seen.changed = True
    elif status is not RUNNING and node in seen.skills and not asked_again(node):
        seen.once_more = {*seen.once_more, node}
        seen.changed = True
    return status


def asked_again(node: Behaviour) -> bool:
    """Return whether a node that has ended is ticked only because one above that runs asks it in every tick."""
    above = node.parent
    while above is not None and above.status is not RUNNING:  # it starts in this tick, and the node with it
        node, above = above, above.parent
    return isinstance(above, Branch) and above.asks_again(node)


def halt(node: Behaviour, reason: str, seen: Seen) -> None:
    """Halt a node and everything below it, children before parents.

    RUNNING nodes are told (``terminate(INVALID)``), once; what has ended only takes the status INVALID.

    Raises:
        Raised: a node raised an exception in ``terminate``.
    """
    if type(node).tick is _BRANCH_TICK:
        for child in node.children:
            if child.status is not INVALID:
                node.halt_child(child, reason, seen)  # type: ignore[attr-defined]  # a Branch
    halt_alone(node, reason, seen)


def halt_alone(node: Behaviour, reason: str, seen: Seen) -> None:
    """Halt one node whose children have been halted; raises as :func:`halt`."""
    if node.status is RUNNING:
        if isinstance(node, Skill):
            node.halt_reason = reason
        try:
            node.stop(INVALID)
        except BaseException as error:
            raise _not_stopped(node, error, seen) from error
        node.feedback_message = f"halted: {reason}"
    else:
        if node in seen.skills and node in seen:
            seen.ends = {**seen.ends, node: End(node.status, node.feedback_message, reported(node))}
        node.feedback_message = ""
    node.status = INVALID
    seen.append(node)
    seen.changed = True


def _own_tick(node: Behaviour) -> Status:
    """Tick a behaviour with a tick of its own, such as one that has children inside."""
    for _ in node.tick():
        pass
    return node.status


def _no_status(node: Behaviour, returned: object) -> Exception:
    """Return what is wrong with what came back from a node: no status, or a process that it forked."""
    if forks.astray:
        return RuntimeError(f"a process that {node.name!r} forked came back from it: it must end with os._exit()")
    forgotten = ": was 'return' forgotten?" if returned is None else ""
    return StatusError(
        f"its status must be SUCCESS, FAILURE or RUNNING, not {shortened(repr(returned), 80)}{forgotten}"
    )


def _check_own(error: BaseException) -> None:
    """Raise again what is somebody's Ctrl-C and not the node's; end a process that the node forked."""
    if forks.astray:
        forks.leave(error)
    if is_ctrl_c(error):
        raise error


def _not_stopped(node: Behaviour, error: BaseException, seen: Seen) -> Raised:
    """Note what a node raised while it was stopped; it counts as halted."""
    _check_own(error)
    node.status = INVALID
    node.feedback_message = f"raised {told(error)}"
    seen.append(node)
    seen.changed = True
    return Raised(node, error)


def _abandon(node: Behaviour, error: BaseException, seen: Seen) -> None:
    """Stop a node that raised: it may hold resources although it never reached RUNNING."""
    if isinstance(node, Skill):
        node.halt_reason = "raised an exception"
    try:
        if isinstance(node, Branch):
            for child in node.children:
                if child.status is not INVALID:
                    node.halt_child(child, f"{node.name!r} raised an exception", seen)
        node.stop(INVALID)
    except BaseException as raised:
        second = raised.error if isinstance(raised, Raised) else raised
        _check_own(second)
        error.add_note(f"and then, while it was stopped: {told(second)}")
    node.status = INVALID
    node.feedback_message = f"raised {told(error)}"
    seen.append(node)
    seen.changed = True
