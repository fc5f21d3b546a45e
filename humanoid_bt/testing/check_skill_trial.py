"""A skill tried: the lives that show whether it keeps the contract."""

from __future__ import annotations

import pickle
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from py_trees.common import Status

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import Place
from humanoid_bt.core.messages import Mode
from humanoid_bt.files.class_files import class_file
from humanoid_bt.testing.check_skill_lives import Actor, Life, Moment, Repeater, Subject, live
from humanoid_bt.testing.check_skill_time import TooLong, clocks_read
from humanoid_bt.tree.ticking.executor import NodeError

LONGEST_TICK = DECISION_PERIOD / 4
"""Time [s] that 99 of 100 ticks of a skill take at most: other nodes have their share of the period, too."""

_EARLY = 25  # 0.5 s
_AFTERWARDS = 50  # ticks in which it is watched after a stop or a loss: 1 s
_UNSEEN = 25  # ticks in which it sees nothing
_HALTED_LIVES = 4000  # ticks of all lives that end with a halt: every tick of a life of 1.8 s ends one


@dataclass
class Halts:
    """What came of halting it.

    Attributes:
        ticks: how many ticks it was halted in.
        of: in how many it ran.
        problem: what was wrong in the first that was not right.
        restart: what it did otherwise when it was started after one, "" if nothing.
    """

    ticks: int = 0
    of: int = 0
    problem: str = ""
    restart: str = ""


@dataclass
class Evidence:
    """All that was seen of a skill.

    Attributes:
        first: its first life, with all that it wants.
        again: the next one, from where the first had ended.
        lives: every life on the robot, by what happened in it.
        overwritten: what it wrote over of what it was given.
        commanded, read: what it commanded and asked for.
        repeated: what another instance did otherwise, on the same, "" if nothing.
        dice: global generators of random numbers that it uses.
        clocks: wall clocks that it reads -> where.
        renewed: what the same instance did otherwise in its second life, "" if nothing.
        halts: what came of halting it.
        took: time of each tick of the first life, the least of several [s].
        slow_at: the line that keeps it, if ticks are too long.
    """

    first: Life = field(default_factory=Life)
    again: Life = field(default_factory=Life)
    lives: dict[str, Life] = field(default_factory=dict)
    overwritten: list[str] = field(default_factory=list)
    commanded: dict[str, None] = field(default_factory=dict)
    read: dict[str, None] = field(default_factory=dict)
    repeated: str = ""
    dice: list[str] = field(default_factory=list)
    clocks: dict[str, Place] = field(default_factory=dict)
    renewed: str = ""
    halts: Halts = field(default_factory=Halts)
    took: list[float] = field(default_factory=list)
    slow_at: Place | None = None

    @property
    def p99(self) -> float:
        """Time that 99 of 100 ticks took at most; of fewer, all of them [s]."""
        return float(np.percentile(self.took, 99, method="higher")) if self.took else 0.0

    @property
    def slow(self) -> bool:
        """Whether ticks take too long: one of 100, or any of them longer than their whole period."""
        return self.p99 > LONGEST_TICK or max(self.took, default=0.0) > DECISION_PERIOD

    @property
    def early(self) -> int:
        """The tick, early in its life, in which it is disturbed."""
        return min(len(self.first.moments) // 3, _EARLY)

    @property
    def same(self) -> bool:
        """Whether another instance does the same, so that instances can be compared."""
        return not (self.repeated or self.dice or self.clocks)


class Trial:
    """Lets a skill live, in every way that the contract speaks of.

    Args:
        subject: the skill.
        timeout: longest time of its first life [s].
    """

    def __init__(self, subject: Subject, timeout: float) -> None:
        self._subject, self._ticks = subject, max(1, round(timeout / DECISION_PERIOD))
        self.seen = Evidence()

    def run(self) -> Evidence:
        """Return what was seen; a skill that raises in its first life is not tried further."""
        seen = self.seen
        try:
            self._first_lives()
        except NodeError as error:
            seen.first = Life([], error)
        if seen.first.error is None:
            try:
                self._further_lives()
            except NodeError as error:
                seen.repeated = f"set up once more, it {Life([], error).raised}"
        return seen

    def _first_lives(self) -> None:
        """Let it live as it would, and again from where it ended; raises NodeError if ``setup`` does."""
        seen, subject = self.seen, self._subject
        subject.begin()
        actor = Actor(subject, subject.lockstep.clock, guarded=True)
        seen.first = self._lived("with all it wants", live(subject, actor, self._ticks))
        if seen.first.status is Status.RUNNING and seen.first.error is None:
            try:
                actor.halt("it is being checked")
            except (NodeError, TooLong) as error:
                seen.halts.problem = f"halted after {len(seen.first.moments)} ticks it {Life([], error).raised}"
        if seen.first.error is None and not seen.halts.problem:
            seen.again = self._lived("again", live(subject, actor, min(len(seen.first.moments), _AFTERWARDS)))
        self._note(actor)

    def _further_lives(self) -> None:
        """Let other instances live; raises NodeError if they cannot be set up."""
        self._repeat()
        self._halt()
        self._measure()
        self._stopped()
        self._blind()

    def _repeat(self) -> None:
        """Let other instances see what the first saw, then the same instance once more."""
        seen, moments = self.seen, self.seen.first.moments
        folder = (class_file(self._subject.node_type.cls) or Path("nowhere")).parent
        dice = _dice()
        repeater = self._repeater()
        life = repeater.live(moments)
        with clocks_read(folder) as seen.clocks:
            another = self._repeater().live(moments)
        seen.dice = [name for name, state in _dice().items() if state != dice[name]]
        seen.repeated = life.differs(seen.first) or another.differs(seen.first)
        renewed = repeater.live(moments)
        seen.renewed = renewed.differs(seen.first)
        if not seen.renewed:
            other = self._repeater().live(seen.again.moments)
            seen.renewed = seen.again.differs(other)
        lives = [seen.first, life, renewed]
        seen.took = [
            min(life.moments[index].took for life in lives if index < len(life.moments))
            for index in range(len(moments))
        ]

    def _halt(self) -> None:
        """Halt it in one tick after the other, and let it begin anew each time."""
        seen, moments = self.seen, self.seen.first.moments
        halts, repeater = seen.halts, self._repeater()
        if halts.problem:
            return
        runs = [index for index, moment in enumerate(moments) if moment.status is Status.RUNNING]
        halts.of = len(runs)
        for index in _some(runs, 3 if seen.slow else 2 * _HALTED_LIVES // max(len(runs), 1)):
            life = repeater.live(moments[: index + 1])
            halts.restart = halts.restart or life.differs(Life(moments[: index + 1]))
            if life.error is not None:
                return
            problem = repeater.halted(moments[min(index + 1, len(moments) - 1)])
            halts.ticks += 1
            if problem:
                halts.problem = f"halted in tick {index + 1} ({moments[index].now - moments[0].now:.2f} s) it {problem}"
                return

    def _measure(self) -> None:
        """Look twice more at ticks that took too long, and where they did."""
        seen, moments = self.seen, self.seen.first.moments
        for _ in range(2):
            if not seen.slow:
                return
            again = self._repeater().live(moments)
            seen.took = [min(took, moment.took) for took, moment in zip(seen.took, again.moments, strict=False)]
        if seen.slow:
            seen.slow_at = self._repeater().live(moments, LONGEST_TICK).hung_at

    def _stopped(self) -> None:
        """Raise the emergency stop early in its life; reset it in the end."""
        subject = self._subject
        early, lockstep = self.seen.early, subject.lockstep
        gives_up = getattr(subject.node_type.cls, "bounded", False)
        ticks = early + (max(self._ticks, _AFTERWARDS) if gives_up else _AFTERWARDS)

        def meanwhile(index: int) -> None:
            if index == early:
                lockstep.sense()  # what is seen in this moment would be missed
                lockstep.supervisor.raise_estop("check_skill", "raised to see what the skill does")
                lockstep.advance()
            elif index == ticks - _AFTERWARDS // 5:
                lockstep.request_reset("check_skill")

        self._live("stopped", ticks, meanwhile)

    def _blind(self) -> None:
        """Take away what it sees: early in its life, and from the beginning."""
        if not self.seen.read:
            return
        subject, early = self._subject, self.seen.early

        def lose_at(tick: int) -> Callable[[int], None]:
            return lambda index: subject.lose() if index == tick else None

        self._live("lost", early + _AFTERWARDS, lose_at(early))
        self._live("never seen", _UNSEEN, lose_at(0))

    def _live(self, name: str, ticks: int, meanwhile: Callable[[int], None]) -> None:
        subject = self._subject
        subject.begin()
        actor = Actor(subject, subject.lockstep.clock, guarded=True)
        self._lived(name, live(subject, actor, ticks, meanwhile))
        self._note(actor)

    def _lived(self, name: str, life: Life) -> Life:
        self.seen.lives[name] = life
        return life

    def _note(self, actor: Actor) -> None:
        seen = self.seen
        seen.commanded |= actor.robot.commanded
        seen.read |= actor.robot.read
        seen.overwritten += [what for what in actor.overwritten if what not in seen.overwritten]

    def _repeater(self) -> Repeater:
        return Repeater(self._subject, guarded=bool(self.seen.overwritten))


def estop_in_force(life: Life) -> list[Moment]:
    """Return the ticks of a life in which the robot was stopped."""
    return [moment for moment in life.moments if moment.state.mode is Mode.EMERGENCY_STOP]


def _some(items: list[int], most: int) -> list[int]:
    """Return all items if they are few, else the first, the last and some in between."""
    if len(items) <= most:
        return items
    return [items[index] for index in np.linspace(0, len(items) - 1, most).round().astype(int).tolist()]


def _dice() -> dict[str, object]:
    """Return the states of the generators of random numbers that everybody shares."""
    return {"random": random.getstate(), "numpy.random": pickle.dumps(np.random.get_state())}
