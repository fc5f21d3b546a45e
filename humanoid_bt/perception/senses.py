"""The percept sources of a run: each looks when it is due, and one that fails is off, and told; the others go on."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import Level, Percept, State, Truth
from humanoid_bt.perception.choice import Chosen, labels
from humanoid_bt.perception.eyes import Eyes
from humanoid_bt.perception.interface import Perception
from humanoid_bt.perception.picture import Picture
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.perception.source import Moment
from humanoid_bt.perception.source_files import TRACKER, whole_ticks
from humanoid_bt.perception.worker import Worker
from humanoid_bt.plant.scene import Scene
from humanoid_bt.robot.model import RobotModel

Show = Callable[[float, Picture], object]
"""Takes a picture that was made for the sources, and its engine time [s]."""


def new_perception(
    chosen: Sequence[Chosen],
    robot: RobotModel,
    scene: Scene,
    *,
    waits: bool,
    show: Show | None = None,
    marks: Sequence[Callable[[], None]] = (),
    off: Mapping[str, str] = MappingProxyType({}),
) -> Perception:
    """Return what sees in a run.

    Args:
        chosen: its sources.
        robot: whose eyes they look with.
        scene: what surrounds it; its seed is that of the sources' random numbers.
        waits: whether time stands still while a source looks, as in lockstep.
        show: takes every picture that is made for the sources, None if nobody wants them.
        marks, off: as of :class:`Senses`.
    """
    if [one.name for one in chosen] == [TRACKER] and not off and set(chosen[0].names) == set(scene.config.percepts):
        return SimulatedPerception(scene, scene.seed)  # trusted: it needs no thread
    return Senses(chosen, robot, scene, waits=waits, show=show, marks=marks, off=off)


@dataclass
class _Sense:
    """A source that works: its worker, every how many ticks it looks, what it needs, and its last look."""

    worker: Worker
    ticks: int
    needs: tuple[str, ...]
    last: int = -1

    def due(self, tick: int) -> bool:
        """Return whether it is to look at this tick."""
        return tick // self.ticks != self.last and not (self.worker.off or self.worker.busy)


class Senses(Perception):
    """Several percept sources, or one that a user wrote.

    Args:
        chosen: the sources.
        robot: whose eyes they look with.
        scene: what surrounds it.
        waits: whether time stands still while a source looks. Else its percepts come when it is done, and it misses
            the looks that are due meanwhile.
        show: takes every picture that is made for the sources, None if nobody wants them.
        marks: called when each of the sources begins to work, and again when it has done it.
        off: sources that are not to work, by label, and why.
    """

    def __init__(
        self,
        chosen: Sequence[Chosen],
        robot: RobotModel,
        scene: Scene,
        *,
        waits: bool,
        show: Show | None = None,
        marks: Sequence[Callable[[], None]] = (),
        off: Mapping[str, str] = MappingProxyType({}),
    ) -> None:
        self._chosen, self._scene, self._waits = chosen, scene, waits
        self._show, self._marks, self._off = show, marks, off
        ticks = [whole_ticks(one.cls.rate) for one in chosen]
        self.period = math.gcd(*ticks) * DECISION_PERIOD if waits else DECISION_PERIOD
        self.names = [name for one in chosen for name in one.names]
        self._ticks = ticks
        works = [one for one, label in zip(chosen, labels(chosen), strict=True) if label not in off]
        sees = any("camera" in one.cls.needs for one in works)
        self._eyes = Eyes(robot, scene) if sees else None
        self._senses: list[_Sense] = []
        self._news: list[tuple[Level, str]] = []
        self._never = dict.fromkeys(self.names, "perception has not looked yet")

    @property
    def unseen(self) -> Mapping[str, str]:
        """The percepts that were never published so far, and why."""
        return self._never

    def start(self) -> None:
        """Set up every source.

        Raises:
            UserError: one cannot be made, or needs the camera, and there are no pictures.
        """
        named = labels(self._chosen)
        made = [one.make(label, self._scene) for one, label in zip(self._chosen, named, strict=True)]
        if self._eyes is not None:
            self._eyes.open()
        for number, (source, label) in enumerate(zip(made, named, strict=True)):
            worker = Worker(source, label, self._marks[number] if self._marks else None)
            self._senses.append(_Sense(worker, self._ticks[number], source.needs))
            if why := self._off.get(label, ""):
                worker.off = why
                self._explain(worker)
        for sense in self._senses:
            if not sense.worker.off:
                sense.worker.set_up()
        for sense in self._senses:
            self._take(sense.worker, wait=True)

    def observe(self, robot: Truth, state: State | None = None) -> list[Percept]:
        """Return what is published now; raises nothing that a source does."""
        tick = round(robot.time / DECISION_PERIOD)
        found = [] if self._waits else self._taken(self._senses)
        due = [sense for sense in self._senses if sense.due(tick)]
        picture = self._picture(due, robot, state)
        for sense in due:
            sense.last = tick // sense.ticks
            never = [name for name in sense.worker.source.names if name in self._never]
            sense.worker.look(_moment(sense, robot, state, picture), never)
        return found + self._taken(due) if self._waits else found

    def take_news(self) -> Sequence[tuple[Level, str]]:
        """Return what happened to the sources since the last time."""
        news, self._news = self._news, []
        return news

    def close(self) -> None:
        """End the threads of the sources, and the camera."""
        for sense in self._senses:
            sense.worker.close()
        self._senses = []
        if self._eyes is not None:
            self._eyes.close()

    def _taken(self, senses: Sequence[_Sense]) -> list[Percept]:
        found = [percept for sense in senses for percept in self._take(sense.worker, wait=self._waits)]
        for percept in found:
            self._never.pop(percept.name, None)
        return found

    def _take(self, worker: Worker, *, wait: bool) -> list[Percept]:
        if worker.off:
            return []
        percepts, unseen = worker.take(wait)
        self._never |= unseen
        if worker.off:
            self._tell_off(worker)
        return percepts

    def _tell_off(self, worker: Worker) -> None:
        self._news.append(("error", f"the percept source {worker.label!r} is off: it {worker.off}"))
        self._explain(worker)

    def _explain(self, worker: Worker) -> None:
        """Say why nothing comes of a source that is off."""
        for name in worker.source.names:
            if name in self._never:
                self._never[name] = f"the percept source {worker.label!r} is off: it {worker.off}"

    def _picture(self, due: Sequence[_Sense], robot: Truth, state: State | None) -> Picture | None:
        """Return a picture if a source needs one now; without pictures those that need one are off."""
        if self._eyes is None or state is None or not any("camera" in sense.needs for sense in due):
            return None
        picture = self._eyes.look(robot, state)
        if picture is None:
            for sense in self._senses:
                if "camera" in sense.needs and not sense.worker.off:
                    sense.worker.off = f"has no picture: {self._eyes.why_none}"
                    self._tell_off(sense.worker)
        elif self._show is not None:
            self._show(robot.time, picture)
        return picture


def _moment(sense: _Sense, robot: Truth, state: State | None, picture: Picture | None) -> Moment:
    needs = sense.needs
    return Moment(
        robot.time,
        state if "state" in needs else None,
        picture if "camera" in needs else None,
        robot if "scene" in needs else None,
    )
