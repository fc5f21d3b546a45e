"""The robot as decision sees it: a snapshot of state and percepts in, targets out, leases on resources.

Targets set during a tick are buffered and leave as one :class:`~humanoid_bt.core.messages.Command` at its end.
"""

from __future__ import annotations

import logging
import math
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from humanoid_bt.core.clock import DECISION_PERIOD, Clock, TreeClock
from humanoid_bt.core.errors import HumanoidBtError, ResourceConflict, nearest
from humanoid_bt.core.geometry import heading_of, rotation_matrix
from humanoid_bt.core.messages import RESOURCES, Array, Command, Level, Percept, State, Target
from humanoid_bt.core.texts import listed
from humanoid_bt.perception.interface import OLDEST
from humanoid_bt.perception.track import Track

if TYPE_CHECKING:  # a skill's file is imported without it
    from humanoid_bt.decision.anatomy import Anatomy
    from humanoid_bt.decision.calls import Calls
    from humanoid_bt.robot.config import RobotConfig
    from humanoid_bt.robot.model import RobotModel

Placed = tuple[Percept, Array, float, Array]
"""A percept, where it is in the world, the heading of the box around it, how the base was turned when it was seen."""

_log = logging.getLogger(__name__)
LEVELS: dict[Level, int] = {"info": logging.INFO, "warning": logging.WARNING, "error": logging.ERROR}

_POSES = round(OLDEST / DECISION_PERIOD)  # of the base that are kept, for percepts that come late


class Commands(Protocol):
    """What sets targets in a node's name, as :class:`~humanoid_bt.decision.robot_handle.RobotHandle` does.

    Attributes:
        path: the node's.
        resources: what it has declared that it commands.
        targets: of this tick, by resource.
        route: the way that the base is to take, shape (n, 2), world frame [m]; None if it is not known.
    """

    path: str
    resources: tuple[str, ...]
    targets: dict[str, Target]
    route: Array | None

    def release(self) -> None:
        """Take back everything asked for in this tick."""


class Robot:
    """Everything decision knows and asks of one robot.

    Args:
        config: the robot's numbers.
        clock: the engine's clock.
        raise_estop: called at once with source and reason when a node raises the emergency stop.
        log: called at once with source, level and text when a node has something to tell; the program's log if None.
        unseen: answers with the percepts that were never published so far, and why.
        model: the robot; made when it is first asked for where parts of the body are if None, which takes a while.
        calls: what carries calls to other programs, None where nothing does.

    Attributes:
        calls: what carries calls to other programs, None where nothing does.
        clock: the tree's clock, which stands still while the run is paused.
        ticks: how many the tree has had, this one included.
    """

    def __init__(
        self,
        config: RobotConfig,
        clock: Clock,
        raise_estop: Callable[[str, str], None] | None = None,
        log: Callable[[str, Level, str], None] | None = None,
        unseen: Callable[[], Mapping[str, str]] | None = None,
        *,
        model: RobotModel | None = None,
        calls: Calls | None = None,
    ) -> None:
        self._raise_estop = raise_estop
        self._model = model
        self._unseen = unseen
        self._tell = log or _to_log
        self.calls = calls
        self.config = config
        self._resources = config.resources
        self._engine_clock = clock
        self.clock = TreeClock(clock)
        self._state: State | None = None
        self._percepts: dict[str, Placed] = {}
        self._tracks: dict[str, Track] = {}  # those that were asked for in this tick
        self._now = 0.0  # the tick's start
        self._past: deque[tuple[float, Array, Array]] = deque(maxlen=_POSES)  # time, position, quaternion of the base
        self._commanding: dict[Commands, None] = {}  # handles that set a target in this tick, in that order
        self._sequence = 0
        self.ticks = 0

    def leave(self) -> None:
        """Let go of the run, which is over: a tree that somebody keeps shall not keep a simulation."""
        if self._unseen is not None:
            unseen = dict(self._unseen())
            self._unseen = lambda: unseen
        self._raise_estop, self._tell, self.calls = None, _to_log, None

    @property
    def now(self) -> float:
        """The engine's time [s]."""
        return self._engine_clock.now()

    @property
    def state(self) -> State:
        """The state at the start of this tick."""
        if self._state is None:
            raise HumanoidBtError("the robot has no state before the first tick")
        return self._state

    @cached_property
    def anatomy(self) -> Anatomy:
        """The robot's body."""
        from humanoid_bt.decision.anatomy import Anatomy  # noqa: PLC0415 (a skill's file needs no simulator)

        return Anatomy(self._model or self.config)

    def track(self, name: str) -> Track | None:
        """Return the latest percept of this name as it was at the start of the tick, or None if never seen."""
        return self._track(name)

    def _track(self, name: str) -> Track | None:
        track = self._tracks.get(name)
        if track is None and (known := self._percepts.get(name)):
            percept, position_world, heading, turn = known
            age = self._now - percept.stamp
            track = self._tracks[name] = Track(percept, position_world, age, self.state, heading, turn=turn)
        return track

    def why_unseen(self, name: str) -> str:
        """Return that a percept is gone, or was never seen and why, for people: ``'cup' was never seen: hidden``."""
        if (track := self._track(name)) is not None and track.gone:
            return f"{name!r} is gone from where it was seen"
        if self._unseen is None:
            return f"{name!r} was never seen"
        unseen = self._unseen()
        why = unseen.get(name, "perception offers no such percept")
        hint = nearest(name, {*unseen, *self._percepts}) if name not in unseen else ""
        return f"{name!r} was never seen: {why}" + (f" ({hint})" if hint else "")

    @property
    def obstacles(self) -> Sequence[Track]:
        """Everything seen so far that is solid, as it was at the start of the tick, but what is known to be gone."""
        solid = [self._track(name) for name, placed in self._percepts.items() if placed[0].size is not None]
        return [track for track in solid if track is not None and not track.gone]

    @property
    def routes(self) -> Sequence[Array]:
        """The ways that nodes follow in this tick, each of shape (n, 2), world frame [m]."""
        return [handle.route for handle in self._commanding if handle.route is not None]

    @property
    def tracks(self) -> Mapping[str, Track]:
        """Every percept seen so far, by name, as it was at the start of the tick."""
        return {name: track for name in self._percepts if (track := self.track(name))}

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop, now and not at the end of the tick; only a reset from outside ends it.

        Args:
            source: path of the node that raises it.
            reason: why.

        Raises:
            HumanoidBtError: this robot has none.
        """
        if self._raise_estop is None:
            raise HumanoidBtError(f"{source!r} raises an emergency stop of a robot that has none: {reason}")
        self._raise_estop(source, reason)

    def log(self, source: str, level: Level, text: str) -> None:
        """Tell something to people, as an event of the run; it is recorded.

        Args:
            source: path of the node that tells it.
            level: how much it matters.
            text: what it tells.
        """
        self._tell(source, level, text)

    def begin_tick(self, state: State, percepts: Mapping[str, Percept]) -> None:
        """Take the snapshot that the whole tick sees, and forget the targets of the last one."""
        self.ticks += 1
        self._look(state, percepts)

    def _look(self, state: State, percepts: Mapping[str, Percept]) -> None:
        self._state = state
        self._now = self._engine_clock.now()
        self._past.append((state.time, state.base_position, state.base_quaternion))
        for name, percept in percepts.items():
            known = self._percepts.get(name)
            if known is None or _is_news(percept, known[0]):
                self._percepts[name] = self._place(percept, known)
        self._tracks.clear()
        for handle in self._commanding:
            handle.release()
        self._commanding.clear()

    def commit(self) -> Command:
        """Return the one command of this tick.

        Raises:
            ResourceConflict: two nodes that are both alive command one resource.
        """
        targets: dict[str, Target] = {}
        sources: dict[str, str] = {}
        for handle in self._commanding:
            for resource, target in handle.targets.items():
                if resource in targets:
                    raise ResourceConflict(
                        f"{resource!r} is commanded by two nodes at once: {sources[resource]!r} and {handle.path!r}"
                    )
                targets[resource] = target
                sources[resource] = handle.path
        command = Command(self._sequence, self.state.time, targets, sources)
        self._sequence += 1
        return command

    def release_all(self) -> Command:
        """Return a command that releases everything."""
        for handle in self._commanding:
            handle.targets.clear()
        return self.commit()

    def stand_still(self, state: State, percepts: Mapping[str, Percept]) -> None:
        """Take a snapshot as :meth:`begin_tick`, of a time that does not pass for the tree."""
        before = self._now if self._state is not None else self._engine_clock.now()
        self._look(state, percepts)
        self.clock.stood += self._now - before

    def repeat(self, command: Command) -> Command:
        """Return a command of an earlier tick as one of now."""
        again = replace(command, sequence=self._sequence, stamp=self.state.time)
        self._sequence += 1
        return again

    def take_over(self, other: Robot) -> None:
        """Go on where another tree's view of the same robot ends.

        What that one knows is known here too, and commands are counted on. Its nodes command no more.
        """
        self._state, self._now, self._past = other._state, other._now, other._past
        self._percepts, self._sequence = other._percepts, other._sequence
        self.clock.stood = other.clock.stood

    def grant(self, handle: Commands, resource: str) -> None:
        """Let a node command a resource in this tick.

        Raises:
            HumanoidBtError: the node has not declared it, or the robot does not have it.
        """
        if resource not in handle.resources:
            wanted = tuple(name for name in RESOURCES if name in (*handle.resources, resource))
            raise HumanoidBtError(f"commands {resource!r} without declaring it; its class needs resources = {wanted}")
        if resource not in self._resources:
            raise HumanoidBtError(f"commands {resource!r}: the robot has none, only {listed(self._resources)}")
        self._commanding[handle] = None

    def _place(self, percept: Percept, known: Placed | None) -> Placed:
        """Return a percept as it is in the world; it has the size of the one known before if it has none itself.

        What is solid stays so until it is gone.
        """
        _, base, quaternion = self._base_at(percept.stamp)
        turn = rotation_matrix(quaternion)
        position: Array = base + turn @ percept.position
        position.setflags(write=False)
        heading = math.remainder(percept.heading + heading_of(turn), math.tau)
        stays = known is not None and (known[0].confidence > 0 or percept.confidence == 0)
        if percept.size is None and known is not None and known[0].size is not None and stays:
            percept, heading = replace(percept, size=known[0].size), known[2]
        return percept, position, heading, quaternion

    def _base_at(self, time: float) -> tuple[float, Array, Array]:
        """Return where the base was at the tick nearest to a time [s], mostly one of the latest."""
        nearest = self._past[-1]
        for pose in reversed(self._past):
            if abs(pose[0] - time) > abs(nearest[0] - time):
                break
            nearest = pose
        return nearest


def _is_news(percept: Percept, known: Percept) -> bool:
    """Return whether a percept says more than one that is known: it is newer, or says that what was seen is gone."""
    return percept.stamp > known.stamp or (percept.stamp == known.stamp and percept.confidence == 0 < known.confidence)


def _to_log(source: str, level: Level, text: str) -> None:
    _log.log(LEVELS[level], "%s: %s", source, text)
