"""How quickly the robot stops, from cause to stop by the monotonic clock, and whether it still stands then."""

from __future__ import annotations

import random
import signal
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from humanoid_bt.bench.promises import E_STOP, PROTECTIVE_STOP, Promise, Verdict, verdict
from humanoid_bt.bench.punctuality import percentile
from humanoid_bt.bench.stand_ins import HANG
from humanoid_bt.bench.subject import Subject, spoil
from humanoid_bt.control.supervisor import DECISION_TIMEOUT
from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import Mode
from humanoid_bt.realtime.schedule import Schedule

ESTOPS_PER_REPETITION = 20
"""An e-stop is over in milliseconds, so many of them can be measured: a p99 needs many."""

MAX_AGE = 0.5
"""Age at which a percept counts as lost [s]: that of the built-in tree's watchdog."""

_PHASE = 0.040  # s over which causes are spread, so that they meet every phase of a tick
_GIVE_UP = 3.0  # s after which a percept should long be lost


@dataclass(frozen=True)
class Reaction:
    """How quickly one cause was answered.

    Attributes:
        cause: what was done.
        answer: what it was measured to.
        loaded: whether every core was busy.
        repetitions: how often it was done.
        delays: from the cause to the answer [ms]; fewer than the repetitions if some were not answered.
        standing: after how many the robot still stood.
        promise: the bound of the p99; None where there is none.
    """

    cause: str
    answer: str
    loaded: bool
    repetitions: int
    delays: tuple[float, ...]
    standing: int
    promise: Promise | None = None

    @property
    def verdict(self) -> Verdict:
        """Whether every cause was answered in time, and the robot stood."""
        every = len(self.delays) == self.standing == self.repetitions
        return verdict(every and (self.promise is None or self.promise.verdict(self.p99) == "ok"))

    @property
    def p50(self) -> float:
        """The median [ms]."""
        return percentile(self.delays, 0.5)

    @property
    def p99(self) -> float:
        """The 99th percentile [ms]; the largest if there are fewer than 100."""
        return percentile(self.delays, 0.99)

    @property
    def largest(self) -> float:
        """The largest [ms]."""
        return max(self.delays, default=0.0)


Trial = Callable[[Subject], float | None]
"""Does a thing once and repairs it; returns the delay [ms], None without an answer."""


def reactions(subject: Subject, repetitions: int, loaded: bool) -> Iterator[Reaction]:
    """Measure every reaction, one after the other.

    Args:
        subject: the robot, followed by a decision. It is so again afterwards.
        repetitions: of each; e-stops have :data:`ESTOPS_PER_REPETITION` times as many.
        loaded: whether every core is busy, for the record.
    """
    phases = random.Random(repetitions)

    def measure(cause: str, answer: str, trial: Trial, count: int, promise: Promise | None) -> Reaction:
        delays: list[float] = []
        standing = 0
        for _ in range(count):
            time.sleep(phases.uniform(0, _PHASE))
            delay = trial(subject)
            if delay is not None:
                delays.append(delay)
            if subject.state.mode is not Mode.DAMP:
                standing += 1
            else:
                subject.restart()
        return Reaction(cause, answer, loaded, count, tuple(delays), standing, promise)

    estops = repetitions * ESTOPS_PER_REPETITION
    stop = "protective stop"
    yield measure("e-stop raised", "emergency stop", _estop, estops, E_STOP)
    yield measure("decision killed", stop, _killed, repetitions, PROTECTIVE_STOP)
    yield measure("decision stopped", stop, _stopped, repetitions, PROTECTIVE_STOP)
    yield measure("decision hangs", stop, _hung, repetitions, PROTECTIVE_STOP)
    yield measure("NaN in every command", stop, _spoilt, repetitions, PROTECTIVE_STOP)
    yield measure("perception killed", f"percept older than {MAX_AGE * 1000:g} ms", _blind, repetitions, None)


def _estop(subject: Subject) -> float | None:
    stops = subject.stops
    began = subject.raise_estop()
    delay = _delay(subject, Mode.EMERGENCY_STOP, stops, began)
    if subject.state.mode is not Mode.DAMP and subject.reset():
        subject.wait_commanded()
    return delay


def _killed(subject: Subject) -> float | None:
    stops = subject.stops
    began = subject.kill("decision")
    return _repaired(subject, _delay(subject, Mode.PROTECTIVE_STOP, stops, began))


def _hung(subject: Subject) -> float | None:
    stops = subject.stops
    began = subject.signal("decision", HANG)
    return _repaired(subject, _delay(subject, Mode.PROTECTIVE_STOP, stops, began))


def _repaired(subject: Subject, delay: float | None) -> float | None:
    """Put a new decision in the place of the one that died or hangs."""
    if subject.wait_stand():
        subject.kill("decision")
        subject.start_decision()
    return delay


def _stopped(subject: Subject) -> float | None:
    stops = subject.stops
    began = subject.signal("decision", signal.SIGSTOP)
    delay = _delay(subject, Mode.PROTECTIVE_STOP, stops, began)
    stands = subject.wait_stand()
    subject.signal("decision", signal.SIGCONT)
    if stands:
        subject.wait_commanded()
    return delay


def _spoilt(subject: Subject) -> float | None:
    stops, refusals = subject.stops, subject.refusals
    began = spoil(subject)
    delay = _delay(subject, Mode.PROTECTIVE_STOP, stops, began)
    refused = subject.refusals > refusals
    stands = subject.wait_stand()
    spoil(subject)
    if stands:
        subject.wait_commanded()
    return delay if refused else None


def _blind(subject: Subject) -> float | None:
    """Kill perception; look as often as a tree would whether its watchdog would bark."""
    schedule = Schedule(DECISION_PERIOD, spin=False)
    began = subject.kill("perception")
    delay = None
    while delay is None and time.monotonic_ns() - began < _GIVE_UP * 1e9:
        schedule.wait()
        if subject.percept_age() > MAX_AGE:
            delay = (time.monotonic_ns() - began) / 1e6
    subject.start_perception()
    return delay


def _delay(subject: Subject, mode: Mode, stops: int, began: int) -> float | None:
    record = subject.wait_stop(mode, stops, timeout=20 * DECISION_TIMEOUT)
    return None if record is None else (record.at - began) / 1e6
