"""What recording adds to a tick of decision: whole runs in realtime mode, with a recording and without, in turn."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from humanoid_bt.bench.promises import RECORDED_TICK, Verdict, verdict
from humanoid_bt.core.messages import Mode, Percept, State
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.session.session import Session

_TREE, _SCENE = "stand", "ball_on_stand"
_TURNS = 2  # of both
_TO_MS = 1e3


@dataclass(frozen=True)
class Ticks:
    """What ticks took from when decision woke up until it slept again, in runs of one kind.

    Attributes:
        loaded: whether every core was busy.
        recorded: whether there was a recording.
        count: of ticks.
        cpu: p99 of the processor's time [ms].
        p50, p99, largest: of the wall clock's, with what went before decision meanwhile [ms].
        stops: protective stops, because decision was silent for too long.
        missing: time that the recordings lack [s].
    """

    loaded: bool
    recorded: bool
    count: int
    cpu: float
    p50: float
    p99: float
    largest: float
    stops: int
    missing: float


@dataclass(frozen=True)
class RecordedTicks:
    """Ticks with a recording beside ticks without one."""

    recorded: Ticks
    plain: Ticks

    @property
    def added(self) -> float:
        """What a recording adds to the p99 of a tick, of the processor's time [ms]."""
        return self.recorded.cpu - self.plain.cpu

    @property
    def verdict(self) -> Verdict:
        """Whether it keeps its promise, and the robot is not stopped more often."""
        return verdict(self.recorded.stops <= self.plain.stops and RECORDED_TICK.verdict(self.added) == "ok")


def recorded_ticks(duration: float, loaded: bool, folder: Path) -> RecordedTicks:
    """Measure ticks of a robot that stands and looks at a ball.

    Args:
        duration: of the runs of each kind together [s].
        loaded: whether every core is busy; that is the caller's to see to.
        folder: for recordings.
    """
    plain, recorded = _Runs(loaded, None), _Runs(loaded, folder / "ticks.rrd")
    for _ in range(_TURNS):
        plain.run(duration / _TURNS)
        recorded.run(duration / _TURNS)
    return RecordedTicks(recorded.ticks, plain.ticks)


class _Runs:
    """Runs of one kind."""

    def __init__(self, loaded: bool, recording: Path | None) -> None:
        self._loaded, self._recording = loaded, recording
        self._took: list[tuple[float, float]] = []  # processor's time, wall clock's [s]
        self._stops, self._missing = 0, 0.0

    def run(self, duration: float) -> None:
        session = Session(
            _TREE,
            workspace=Workspace(builtin_root()),
            scene=_SCENE,
            mode="realtime",
            record=self._recording or False,
            camera=False,
        )
        sense = session.engine.sense
        woke: tuple[float, float] | None = None

        def timed() -> tuple[State, Mapping[str, Percept]]:
            nonlocal woke
            if woke is not None:
                self._took.append((time.thread_time() - woke[0], time.perf_counter() - woke[1]))
            sensed = sense()
            woke = time.thread_time(), time.perf_counter()
            return sensed

        session.engine.sense = timed  # type: ignore[method-assign]  # where a tick begins and ends
        with session:
            session.step()
            session.run_until(session.time + duration)
        self._stops += sum(stop["mode"] == Mode.PROTECTIVE_STOP.value for stop in session.report.stops)
        self._missing += session.report.recording_missing

    @property
    def ticks(self) -> Ticks:
        cpu, wall = _TO_MS * np.array(self._took).T
        p50, p99, largest = np.percentile(wall, (50, 99, 100)).tolist()
        return Ticks(
            loaded=self._loaded,
            recorded=self._recording is not None,
            count=len(cpu),
            cpu=float(np.percentile(cpu, 99)),
            p50=p50,
            p99=p99,
            largest=largest,
            stops=self._stops,
            missing=self._missing,
        )
