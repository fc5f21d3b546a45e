"""A recorded lockstep run, run again as a whole: the tree, control, the simulated robot, and what came from outside."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from itertools import takewhile
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.messages import Array, Estimate, Level
from humanoid_bt.decision.result import Reported
from humanoid_bt.perception.choice import written
from humanoid_bt.perception.track import Track
from humanoid_bt.record.reading import FlightLog
from humanoid_bt.record.subject import TreeView
from humanoid_bt.record.tick import Tick
from humanoid_bt.review.compare_run import Parting, node_parting, tick_parting
from humanoid_bt.review.decision_replay import Done, do_again, is_paused
from humanoid_bt.review.recorded_files import RecordedFiles
from humanoid_bt.review.recorded_run import TO_TREE, RecordedRun
from humanoid_bt.session.drive import Drive
from humanoid_bt.session.listener import Listener
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.options import RunOptions

_FOREVER = 1e9  # s
_AT = 1e-9  # s; engine times are sums of floats
_LEAD = dict.fromkeys(("reset", *TO_TREE), DECISION_PERIOD)  # s by which what waits for the next tick is given before


def run_again(log: FlightLog, run: RecordedRun, files: RecordedFiles) -> Done:
    """Run a recorded run again and compare every tick.

    Args:
        log: what was recorded.
        run: what it says about its run.
        files: what it was made of.

    Raises:
        UserError: the tree, robot or scene has mistakes.
        NodeError: a skill raised an exception in ``setup``.
    """
    options = RunOptions(
        tree=str(files.tree),
        robot=str(files.robot),
        scene=str(files.scene),
        body=run.body,
        perception=written(log.setup.get("perception")),
        parameters=run.given,
        seed=run.seed,
        duration=min(run.duration, _FOREVER),
        on_estop="wait" if run.waits else "end",
        camera=False,
    )
    until, why = _broken_off(log, run)
    comparison = Comparison(log, run, whole=run.ended and not why, until=until)
    drive = Drive(options, files.workspace, Listener(), comparison)
    engine = drive.engine
    assert isinstance(engine, Lockstep)
    outside = _Outside(engine, run, drive)
    drive.start()
    try:
        while drive.running:
            state = drive.loop.state
            if comparison.exhausted or (state is not None and state.time > run.tree_ended - _AT):
                drive.leave(run.outcome or "unfinished", run.reason or "the recording ends")
            else:
                outside.act()
                drive.tick()
    finally:
        drive.close()
    report = drive.report
    assert report is not None
    comparison.finish()
    notes = [why] if why else []
    return Done(comparison.difference, comparison.count, comparison.lasted, report.outcome, report.reason, notes)


def _broken_off(log: FlightLog, run: RecordedRun) -> tuple[float, str]:
    """Return the engine time [s] up to which a run can be run again, and why no longer; infinity, "" for all of it."""
    paused = next((tick.state.time for tick in log.ticks() if is_paused(tick)), math.inf)
    rested = run.tree_ended + _AT if run.rested else math.inf
    until, what = min(
        (run.edited, "the tree was edited"),
        (paused, "somebody paused the run"),
        (rested, "the run went on after its tree, which ended"),
    )
    return (until, f"{what} at {until:.2f} s: the rest is not compared") if until < math.inf else (math.inf, "")


class _Outside:
    """Does again what came from outside, at its time.

    Args:
        engine: of the run.
        run: what was recorded of it.
        drive: the run.
    """

    def __init__(self, engine: Lockstep, run: RecordedRun, drive: Drive) -> None:
        self._engine, self._supervisor, self._drive = engine, engine.supervisor, drive
        self._inputs, self._estops = deque(run.inputs), deque(run.estops)
        check = self._supervisor.check

        def raised_again(
            cycle: int,
            estimate: Estimate,
            setpoint_fault: str = "",
            sensor_fault: str = "",
            plant_fault: str = "",
        ) -> None:
            if self._estops and self._estops[0][0] <= cycle:
                self._supervisor.raise_estop(*self._estops.popleft()[1:])
            check(cycle, estimate, setpoint_fault, sensor_fault, plant_fault)

        self._supervisor.check = raised_again  # type: ignore[method-assign]  # what nobody in this process raises

    def act(self) -> None:
        """Do what comes before the next tick."""
        now, begun = self._engine.clock.now(), self._drive.loop.state is not None
        lead = _LEAD if begun else {}  # the first tick is at once
        while self._inputs and self._inputs[0].time - lead.get(self._inputs[0].kind, 0.0) <= now + _AT:
            _, kind, value = self._inputs.popleft()
            match kind:
                case "push":
                    body, force, duration = value
                    self._engine.push(body, np.array(force), duration)
                case "reset":
                    self._engine.request_reset(value)
                case "reset_after_tick":
                    self._supervisor.reset()
                case _ if kind in TO_TREE:
                    do_again(self._drive.runner.tree, kind, value, begun)


class Comparison:
    """Takes what would be recorded of a run, and compares it with a recording.

    Args:
        log: the recording.
        run: what it says about its run.
        whole: whether the run came to its end when it was recorded, and is compared up to that.
        until: engine time up to which it is compared [s].

    Attributes:
        difference: the first, None as long as there is none.
        count: ticks that were compared.
        lasted: how long they lasted [s].
        exhausted: whether the recording has no more ticks.
        url, missing: nothing is shown, and nothing is lost.
    """

    def __init__(self, log: FlightLog, run: RecordedRun, whole: bool, until: float) -> None:
        self._whole = whole
        self._joints = run.joints
        self._ticks = takewhile(lambda tick: tick.state.time < until, log.ticks())
        self._next = next(self._ticks, None)
        self._nodes = deque(node for node in run.nodes if node[0] < until)
        self._first = self._next.state.time if self._next is not None else 0.0
        self.difference: Parting | None = None
        self.count, self.lasted, self.exhausted = 0, 0.0, self._next is None
        self.url, self.missing = "", 0.0

    def routes(self, time: float, routes: Sequence[Sequence[Sequence[float]]]) -> None:
        """Ignore them: they follow from the rest."""

    def truth(self, time: float, pose: Sequence[float]) -> None:
        """Ignore it: it follows from the rest."""

    def sample(
        self, tick: Tick, _tracks: Mapping[str, Track], _objects: Mapping[str, Array], _hidden: Iterable[str] = ()
    ) -> None:
        """Compare a tick."""
        self._miss(tick.state.time)
        recorded = self._next
        if recorded is None:
            if self._whole:
                self._note(Parting(tick.state.time, "the run", "ended", "went on"))
            return
        self.count, self.lasted = self.count + 1, tick.state.time - self._first
        if self.difference is None:
            self._note(tick_parting(recorded, tick, self._joints))
        self._next = next(self._ticks, None)
        self.exhausted = self._next is None and not self._whole

    def node_changed(self, time: float, path: str, status: str, feedback: str) -> None:
        """Compare a node's change of status."""
        self._miss(time)
        if self._nodes and self._nodes[0][0] == time:
            _, known, was, said = self._nodes.popleft()
            if (known, was) != (path, status):
                self._note(node_parting(time, (known, was), (path, status)))
            elif said != feedback:
                self._note(Parting(time, f"node {path} says", said, feedback))
        elif self._nodes or self._whole:
            self._note(node_parting(time, None, (path, status)))

    def finish(self) -> None:
        """Note what was recorded and did not come again."""
        if self._whole:
            self._miss(math.inf if self._next is None else self._next.state.time)
            if self._next is not None:
                self._note(Parting(self._next.state.time, "the run", "went on", "ended"))

    def _miss(self, before: float) -> None:
        """Note the first change of a node that should have come before an engine time [s], and did not."""
        if self._nodes and self._nodes[0][0] < before:
            at, path, status, _ = self._nodes[0]
            self._note(node_parting(at, (path, status), None))

    def _note(self, difference: Parting | None) -> None:
        self.difference = self.difference or difference

    # ---- what is not compared: it follows from the rest --------------------------------------------------------------

    def open(self, **_setup: Any) -> None:
        """Begin."""

    def follow(self, plans: Path, cycles: Path) -> None:
        """Ignore them."""

    def cycles(self, plans: Array, cycles: Array) -> None:
        """Ignore them."""

    def results(self, time: float, path: str, results: Sequence[Reported]) -> None:
        """Ignore them."""

    def show_tree(self, time: float, tree: TreeView, info: Mapping[str, str]) -> None:
        """Ignore it."""

    def event(self, time: float, level: Level, text: str) -> None:
        """Ignore it."""

    def news(self, time: float, kind: str, value: Any) -> None:
        """Ignore them."""

    def take_news(self) -> list[tuple[Level, str]]:
        """Return nothing."""
        return []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass
