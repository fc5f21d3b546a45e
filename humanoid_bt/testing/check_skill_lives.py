"""The lives of a skill that is tried: on the simulated robot, and again on what was seen there."""

from __future__ import annotations

import copy
import itertools
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any, Protocol

from py_trees.common import Status

from humanoid_bt.core.clock import Clock
from humanoid_bt.core.errors import Place
from humanoid_bt.core.messages import Command, Percept, State
from humanoid_bt.core.plain import plain
from humanoid_bt.core.texts import told
from humanoid_bt.decision.result import results_of
from humanoid_bt.decision.robot import Robot
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.testing.check_skill_robot import WatchedRobot
from humanoid_bt.testing.check_skill_time import TooLong, at_most
from humanoid_bt.tree.node_type import NodeType
from humanoid_bt.tree.ticking.executor import Executor, NodeError
from humanoid_bt.tree.tree import Tree

LONGEST = 5.0
"""Time [s] after which a tick is taken for one that never ends."""

_PAUSE = 0.02  # s for threads


class Subject(Protocol):
    """A skill with its parameters, and the robot on which it is tried."""

    @property
    def node_type(self) -> NodeType:
        """The skill's type."""
        ...

    @property
    def values(self) -> Mapping[str, Any]:
        """Its parameters, converted."""
        ...

    @property
    def lockstep(self) -> Lockstep:
        """The robot."""
        ...

    def make(self) -> Tree:
        """Return a tree of the skill alone, made anew."""
        ...

    def begin(self) -> None:
        """Let the robot stand at its start and see what it is to see."""
        ...

    def lose(self) -> None:
        """Let perception of everything end."""
        ...


@dataclass(frozen=True)
class Moment:
    """One tick of a skill.

    Attributes:
        now: engine time [s].
        state, percepts: what it saw.
        status: what it returned.
        feedback: what it said.
        targets: what it commanded, as plain data.
        results: what it had reported, by name.
        took: how long the tick took [s].
    """

    now: float
    state: State
    percepts: Mapping[str, Percept]
    status: Status
    feedback: str
    targets: Mapping[str, Any]
    results: Mapping[str, Any]
    took: float

    @property
    def did(self) -> tuple[Any, ...]:
        """All by which two ticks are compared."""
        return self.status, self.feedback, self.targets, self.results


@dataclass
class Life:
    """What a skill did from its start to its end, tick by tick.

    Attributes:
        moments: its ticks.
        error: what it raised in the tick after them, None if nothing.
    """

    moments: list[Moment] = field(default_factory=list)
    error: BaseException | None = None

    @property
    def status(self) -> Status:
        """What it returned last."""
        return self.moments[-1].status if self.moments else Status.INVALID

    @property
    def raised(self) -> str:
        """What it raised, and where."""
        error = self.error
        if not isinstance(error, NodeError):
            return told(error) if error else ""
        return f"raised {told(error.error)}" + (f" at {error.where}" if error.where else "")

    @property
    def hung(self) -> bool:
        """Whether a tick did not come back in time."""
        return isinstance(getattr(self.error, "error", self.error), TooLong)

    @property
    def hung_at(self) -> Place | None:
        """The line of the skill's file in which it was then."""
        return self.error.where if isinstance(self.error, NodeError) else None

    def differs(self, other: Life) -> str:
        """Return the first thing that this life did otherwise than another, "" if all is the same."""
        for index, (mine, its) in enumerate(zip(self.moments, other.moments, strict=False)):
            if mine.did != its.did:
                return f"in tick {index + 1} ({mine.now - self.moments[0].now:.2f} s) {_difference(mine, its)}"
        if self.raised != other.raised and not (self.hung or other.hung):
            return f"{self.raised or 'raised nothing'}, before: {other.raised or 'nothing'}"
        return ""


class Actor:
    """One instance of a skill, set up on a watched robot.

    Args:
        subject: the skill.
        clock: what tells it the time.
        guarded: whether it gets copies of what it sees, which it can write to.

    Attributes:
        robot: the robot as it sees it.
        command: what it asked for in the last tick.

    Raises:
        NodeError: it raised an exception in ``setup``.
        UserError: it lacks something.
    """

    def __init__(self, subject: Subject, clock: Clock, guarded: bool = False) -> None:
        lockstep = subject.lockstep
        raise_estop = lockstep.supervisor.raise_estop if clock is lockstep.clock else _to_nobody
        self._clock, self._guarded = clock, guarded
        self.robot = WatchedRobot(lockstep.robot.config, clock, raise_estop, lambda: lockstep.unseen)
        self._blank = Robot(lockstep.robot.config, clock)
        self._executor = Executor(subject.make(), self.robot)
        self._executor.setup()
        self._given: list[tuple[Any, Any]] = []
        self.command = Command(0, 0.0)
        self._ticks = itertools.count()

    def start(self) -> None:
        """Begin another life: halt it if it runs, forget what was seen, and what was said of the halt."""
        if self._executor.status is Status.RUNNING:
            self.halt("it begins anew")
        self._executor.tree.root.feedback_message = ""
        self.robot.take_over(Robot(self._blank.config, self._clock))

    def tick(self, state: State, percepts: Mapping[str, Percept], longest: float = LONGEST) -> Moment:
        """Tick it once; raises as :meth:`Executor.tick`, or TooLong."""
        given = state, percepts
        if self._guarded:
            given = _writable(state), copy.deepcopy(percepts)
            self._given.append(((state, percepts), given))
        behaviour = self._executor.tree.root
        with at_most(longest):
            began = time.perf_counter()
            command = self._executor.tick(*given)
            took = time.perf_counter() - began
        self.command = replace(command, sequence=next(self._ticks))  # counted on in the next life, as control wants it
        status, feedback = behaviour.status, behaviour.feedback_message
        targets, results = plain(self.command.targets), dict(results_of(behaviour))
        return Moment(self._clock.now(), state, percepts, status, feedback, targets, results, took)

    def halt(self, reason: str) -> tuple[str, ...]:
        """Halt it in the middle of a tick; return what it commands all the same. Raises as :meth:`Executor.halt`."""
        with at_most(LONGEST):
            self._executor.halt(reason)
        return tuple(self.robot.commit().targets)

    @property
    def overwritten(self) -> list[str]:
        """What it wrote over of what it was given, such as ``state.hands``."""
        found = dict.fromkeys(f"track({name!r}).position_world" for name in self.robot.overwritten)
        for (state, percepts), (given_state, given_percepts) in self._given:
            before, after = plain(state), plain(given_state)
            found |= dict.fromkeys(f"state.{name}" for name in before if before[name] != after[name])
            if plain(percepts) != plain(given_percepts):
                found["percepts"] = None
        return list(found)


def _writable(state: State) -> State:
    """Return a copy of a state that a skill can write over."""
    values: dict[str, Any] = {one.name: getattr(state, one.name) for one in fields(state)}
    copied: dict[str, Any] = {name: dict(v) if isinstance(v, Mapping) else v for name, v in values.items()}
    return State(**copy.deepcopy(copied))


def live(subject: Subject, actor: Actor, ticks: int, meanwhile: Callable[[int], None] = lambda _index: None) -> Life:
    """Let a skill live on the simulated robot until it ends or has had its ticks.

    Args:
        subject: the skill.
        actor: an instance of it.
        ticks: how many at most.
        meanwhile: called before each tick with its index.
    """
    life, lockstep = Life(), subject.lockstep
    try:
        actor.start()
        for index in range(ticks):
            meanwhile(index)
            state, percepts = lockstep.sense()
            life.moments.append(actor.tick(state, percepts))
            if life.status is not Status.RUNNING:
                break
            lockstep.submit(actor.command)
            lockstep.advance()
    except (NodeError, TooLong) as error:
        life.error = error
    return life


class _HeldClock:
    """A clock that shows the time it is given."""

    def __init__(self) -> None:
        self.time = 0.0

    def now(self) -> float:
        return self.time


class Repeater:
    """An instance of a skill that lives again on what was seen before: without physics, at the same times.

    Args:
        subject: the skill.
        guarded: as of :class:`Actor`.
    """

    def __init__(self, subject: Subject, guarded: bool = False) -> None:
        self._clock = _HeldClock()
        self._threads = threading.active_count()
        self.actor = Actor(subject, self._clock, guarded)

    def live(self, moments: Sequence[Moment], longest: float = LONGEST) -> Life:
        """Start it, and let it see what was seen in these moments."""
        life = Life()
        try:
            self.actor.start()
            for moment in moments:
                self._clock.time = moment.now
                life.moments.append(self.actor.tick(moment.state, moment.percepts, longest))
        except (NodeError, TooLong) as error:
            life.error = error
        return life

    def halted(self, moment: Moment) -> str:
        """Halt it; return what is wrong then, or in a tick without it on what this moment saw, "" if nothing."""
        try:
            kept = self.actor.halt("it is being checked")
        except (NodeError, TooLong) as error:
            return Life([], error).raised
        if kept:
            return f"still commanded {', '.join(kept)}"
        self.actor.robot.begin_tick(moment.state, moment.percepts)
        if threading.active_count() > self._threads:
            time.sleep(_PAUSE)  # a thread that it has left behind may command on
        later = tuple(self.actor.robot.commit().targets)
        return f"commanded {', '.join(later)} in the tick after it" if later else ""


def _to_nobody(_source: str, _reason: str) -> None:
    """Take an emergency stop that was raised before."""


def _difference(mine: Moment, its: Moment) -> str:
    if mine.status is not its.status:
        return f"it was {mine.status.name} ({mine.feedback!r}), before {its.status.name} ({its.feedback!r})"
    if mine.targets != its.targets:
        names = [name for name in {**mine.targets, **its.targets} if mine.targets.get(name) != its.targets.get(name)]
        return f"it commanded {names[0]} {_target(mine, names[0])}, before {_target(its, names[0])}"
    if mine.feedback != its.feedback:
        return f"it said {mine.feedback!r}, before {its.feedback!r}"
    names = [name for name in {**mine.results, **its.results} if mine.results.get(name) != its.results.get(name)]
    return f"its {names[0]} was {mine.results.get(names[0])}, before {its.results.get(names[0])}"


def _target(moment: Moment, resource: str) -> str:
    target = moment.targets.get(resource)
    if target is None:
        return "to nothing"
    return f"to ({', '.join(_told(target))})"


def _told(value: Any) -> Iterator[str]:
    """Yield what a target says, as texts; nothing for what it leaves open."""
    if isinstance(value, dict):
        value = list(value.values())
    if isinstance(value, list):
        for part in value:
            yield from _told(part)
    elif isinstance(value, float):
        yield f"{value:.3g}"
    elif value:
        yield str(value)
