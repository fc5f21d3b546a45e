"""What a recording says of a run: which node did what and when, what was seen, commanded and stopped."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from py_trees.common import Status

from humanoid_bt.core.clock import SERVO_PERIOD
from humanoid_bt.core.errors import UserError, nearest
from humanoid_bt.core.messages import Percept
from humanoid_bt.record.reading import AT, FlightLog
from humanoid_bt.record.tick import Tick
from humanoid_bt.review.setup import ran_at
from humanoid_bt.tree.ticking.deciding import deciding
from humanoid_bt.tree.ticking.executor import NodeChange

_TICKS = (0.5, 10.0, math.inf)  # s before a moment in which its last tick is looked for, one after the other
_SILENT = 0.1  # s without a tick after which nobody knows that a node still ran
_SIGHTS = 60.0  # s for which percepts are looked for

COMMANDED = ("run", "paused")
"""Modes in which nothing stops the robot."""

HALTED = "halted: "
"""How begins what a node says that was halted while it ran."""

_OVER = "the run ended"
OVER = HALTED + _OVER
"""What it says if the end of the run halted it."""


class Change(NamedTuple):
    """A node's status changed: when [s], which node, to what, and what it said."""

    time: float
    path: str
    status: str
    said: str


class Happened(NamedTuple):
    """Something happened: when [s], how bad, and what."""

    time: float
    level: str
    text: str


class Stopped(NamedTuple):
    """The supervisor ordered a stop.

    Attributes:
        time: when [s].
        mode: the kind of stop.
        reason, source: why, and by whom.
        resources: resource -> path of the node whose command was in force.
    """

    time: float
    mode: str
    reason: str
    source: str
    resources: Mapping[str, str]


class Span(NamedTuple):
    """How long the supervisor was in a mode: from, until [s]; ``until`` is the next mode's begin."""

    begin: float
    until: float
    mode: str


class Sight(NamedTuple):
    """What was known of a percept: its age [s], its confidence, and how far away it was from the base [m]."""

    name: str
    age: float
    confidence: float
    distance: float


class History:
    """A run, as its recording has it.

    Args:
        log: the recording.

    Attributes:
        setup: what was run.
        damage: what of the recording was changed since it was written, a text each.
        stops: every stop that decision was told of.
        end: how the run ended, empty if the recording does not say.
        begin, until: engine times of the first and last servo cycle in it, or tick if it has none [s].
        ticked_from: engine time of the first tick [s]; in realtime mode control has run for a while by then.
    """

    def __init__(self, log: FlightLog) -> None:
        self.log, self.setup, self.damage = log, log.setup, log.damage
        news = list(log.news_of("node", "event", "stop", "tree", "end"))
        self.changes = [Change(time, *value) for time, kind, value in news if kind == "node"]
        self.events = [Happened(time, *value) for time, kind, value in news if kind == "event"]
        self.stops = [_stopped(value) for _, kind, value in news if kind == "stop"]
        self.end: dict[str, Any] = next((value for _, kind, value in news if kind == "end"), {})
        self._trees = [(-math.inf, self.setup["tree"])]
        self._trees += [(time, value) for time, kind, value in news if kind == "tree"]
        self._nodes = [(since, {node["path"]: node for node in tree["nodes"]}) for since, tree in self._trees]
        self._sights: dict[float, list[Sight]] = {}
        self.begin, self.until = log.span
        if not self.until and (last := self.last_tick) is not None:  # a dry run has no servo cycles
            self.begin, self.until = next(log.ticks()).state.time, last.state.time
        self.ticked_from = self.changes[0].time if self.changes else self.begin

    # ---- nodes ------------------------------------------------------------------------------------------------------

    def tree(self, time: float = math.inf) -> Mapping[str, Any]:
        """Return what is kept of the tree that ran at a time [s]."""
        return ran_at(self._trees, time)

    def nodes(self, time: float = math.inf) -> dict[str, Mapping[str, Any]]:
        """Return what is kept of the nodes of the tree that ran at a time [s], by path."""
        return ran_at(self._nodes, time)

    def kind(self, path: str, time: float = math.inf) -> Mapping[str, Any]:
        """Return what is kept of a node of the tree that ran at a time [s], nothing if it is unknown."""
        return self.nodes(time).get(path, {})

    def place(self, path: str, time: float = math.inf) -> str:
        """Return where a node stands in its file, "" if that is not known."""
        return str(self.kind(path, time).get("place", ""))

    def matching(self, name: str) -> list[str]:
        """Return the paths of the nodes that a name means: a path, its end, or the node's type.

        Raises:
            UserError: no node is named so.
        """
        types = [(path, node["type"]) for _, nodes in self._nodes for path, node in nodes.items()]
        known = list(dict.fromkeys(path for path, _ in types))
        found = [path for path in known if path == name or path.endswith("/" + name)]
        found = found or list(dict.fromkeys(path for path, of in types if of == name))
        if not found:
            names = {path.rsplit("/", 1)[-1] for path in known}
            raise UserError(f"no node of {self.tree()['name']!r} is named {name!r}", hint=nearest(name, names))
        return found

    def running(self, time: float) -> dict[str, Change]:
        """Return the nodes that ran at a time [s], by path, each with the change that began it."""
        return _running(self.changes, time)

    def acting(self, time: float) -> list[Change]:
        """Return the deepest of the nodes that ran at a time [s]."""
        return _deepest(_running(self.changes, time))

    def acting_last(self) -> list[Change]:
        """Return the deepest of the nodes that ran when the run ended, which halted them."""
        return _deepest({path: change for path, change in self.at_last.items() if change.status == "RUNNING"})

    @cached_property
    def at_last(self) -> dict[str, Change]:
        """The last change of each node before the end of the run halted it, by path."""
        kept = len(self.changes)
        while kept and self._by_the_end(self.changes[kept - 1]):
            kept -= 1
        return {change.path: change for change in self.changes[:kept]}

    @cached_property
    def decided(self) -> Change | None:
        """The change of the node that decided how the tree ended, None if it was never ticked."""
        changes = [NodeChange(time, path, Status[status], said) for time, path, status, said in self.changes]
        found = deciding(changes)
        return None if found is None else Change(found.time, found.path, found.status.name, found.feedback)

    def silent_since(self, time: float) -> float | None:
        """Return when decision ticked last [s], None if that was right before a time [s], or the tree had ended."""
        tick, ended = self.tick(time), self.end.get("tree_ended")
        if tick is None or (ended is not None and time >= ended - AT):
            return None
        return tick.state.time if time - tick.state.time > _SILENT else None

    def _by_the_end(self, change: Change) -> bool:
        """Return whether the end of the run halted a node, not the tree in its last tick, which may be as late."""
        ended = self.end.get("tree_ended")
        if ended is None or change.status != "INVALID" or change.time < ended - AT:
            return False
        why = change.said.removeprefix(HALTED)
        return why == change.said or why.startswith((_OVER, self.end["reason"] or _OVER))

    # ---- ticks ------------------------------------------------------------------------------------------------------

    def tick(self, time: float) -> Tick | None:
        """Return the last tick up to a time [s]."""
        latest = min(time, self.log.until["ticks"][-1]) if self.log.until["ticks"] else time
        for window in _TICKS:
            ticks = list(self.log.ticks(latest - window, time + AT))
            if ticks:
                return ticks[-1]
        return None

    @cached_property
    def last_tick(self) -> Tick | None:
        """The last tick in the recording."""
        return self.tick(math.inf)

    def sights(self, time: float) -> list[Sight]:
        """Return what was known of each percept at a time [s], the freshest first."""
        if time not in self._sights:  # a minute of the recording is read for it
            self._sights[time] = self._seen(time)
        return self._sights[time]

    def _seen(self, time: float) -> list[Sight]:
        found: dict[str, Percept] = {}
        for percept in self.log.seen_before(time):
            found.setdefault(percept.name, percept)
            if time - percept.stamp > _SIGHTS:
                break
        sights = [
            Sight(percept.name, max(time - percept.stamp, 0.0), percept.confidence, _distance(percept))
            for percept in found.values()
        ]
        return sorted(sights, key=lambda sight: (sight.age, sight.name))

    def value(self, written: Any, time: float = math.inf) -> Any:
        """Return what a node's parameter is, which may be written as ``$name``."""
        if not (isinstance(written, str) and written.startswith("$")):
            return written
        return self.tree(time)["parameters"].get(written[1:], {}).get("value", written)

    # ---- modes ------------------------------------------------------------------------------------------------------

    def modes(self, begin: float, end: float) -> list[Span]:
        """Return the modes of the supervisor between two times [s], to the servo cycle."""
        cycles = self.log.cycles("cycles", begin, end, ["servo"])
        if not len(cycles.time):
            return []
        numbers = cycles.columns["servo"][:, 1].astype(int)
        starts = [0, *(np.flatnonzero(np.diff(numbers)) + 1).tolist()]
        ends = [*starts[1:], len(numbers)]
        names = dict(enumerate(self.log.layout["modes"]))
        modes = [names.get(numbers[first], "?") for first in starts]
        began = (cycles.time - SERVO_PERIOD).tolist()  # a row is written when its cycle is over
        return [
            Span(began[first], began[after] if after < len(numbers) else float(cycles.time[-1]), mode)
            for first, after, mode in zip(starts, ends, modes, strict=True)
        ]

    def went_on(self, stop: Stopped) -> float | None:
        """Return when the robot went on after a stop [s], None if it did not."""
        later = (mode for mode in self._modes if mode.begin > stop.time and mode.mode in COMMANDED)
        return next((mode.begin for mode in later), None)

    @cached_property
    def _modes(self) -> list[Span]:
        """The modes of the supervisor in the whole run."""
        return self.modes(self.begin, self.until)

    def results(self, path: str, begin: float = -math.inf, end: float = math.inf) -> Iterator[tuple[float, list[Any]]]:
        """Yield what a skill reported: time [s], and name, value, unit of each result."""
        for time, _, (of, results) in self.log.news_of("results", begin=begin, end=end):
            if of == path:
                yield time, results


def _running(changes: list[Change], time: float) -> dict[str, Change]:
    last: dict[str, Change] = {}
    for change in changes:
        if change.time > time + AT:
            break
        last[change.path] = change
    return {path: change for path, change in last.items() if change.status == "RUNNING"}


def _deepest(running: dict[str, Change]) -> list[Change]:
    return [change for path, change in running.items() if not any(other.startswith(path + "/") for other in running)]


def _stopped(value: Mapping[str, Any]) -> Stopped:
    return Stopped(*(value[name] for name in Stopped._fields))


def _distance(percept: Percept) -> float:
    return math.hypot(*percept.position[:2].tolist())
