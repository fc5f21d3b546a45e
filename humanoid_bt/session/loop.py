"""The loop of a run, one tick at a time, and how it ends."""

from __future__ import annotations

from py_trees.common import Status

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Mode, State
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.outcome import End, failed
from humanoid_bt.session.pace import Pace
from humanoid_bt.session.reload import Reloader
from humanoid_bt.session.teller import Teller
from humanoid_bt.session.tree_runner import TreeRunner

_AFTER_STOP = 2.0  # s after a latched stop until the run ends, if the tree goes on


class Loop:
    """Ticks the tree until its end.

    Args:
        engine: control, plant and perception.
        runner: what runs the tree.
        teller: is told what happens.
        pace: how fast simulated time goes.
        duration: longest simulated time [s].

    Attributes:
        reloader: puts edited trees in the tree's place, if anybody looks for edits.
        state: what the last tick saw, None before the first.
    """

    def __init__(self, engine: Engine, runner: TreeRunner, teller: Teller, pace: Pace, duration: float) -> None:
        self._engine, self._runner, self._teller, self._pace = engine, runner, teller, pace
        self._duration = duration
        self.reloader: Reloader | None = None
        self.state: State | None = None

    def tick(self) -> End | None:
        """Let the time since the last tick pass, then tick the tree; return how the run ends, None if it goes on.

        Raises:
            ControlLost: control is gone.
        """
        engine, runner, teller = self._engine, self._runner, self._teller
        if self.state is None:
            teller.warn_of_percepts(runner.tree)
        else:
            engine.advance()
            self._pace.keep(engine.clock.now())
            if self.reloader is not None:
                self.reloader.look()
        state, percepts = engine.sense()
        self.state = state
        teller.happened(state.time)
        try:
            command = runner.tick(state, percepts)
        except HumanoidBtError as error:
            return failed(error)
        teller.trace.tick(state, command)
        teller.ticked(state, runner)
        end = self._end(state)
        if end is None:
            engine.submit(command)
        return end

    def leave(self, outcome: str, reason: str) -> End:
        """Return how the run ends that somebody ends between two ticks."""
        return self._runner.ended or End(outcome, reason)

    def _end(self, state: State) -> End | None:
        """Return how the run ends after this tick, None if it goes on."""
        latched = state.mode in (Mode.EMERGENCY_STOP, Mode.DAMP)
        stopped = End("stopped", f"{state.stop_reason} ({state.stop_source})")
        runner, status = self._runner, self._runner.status
        if status in (Status.SUCCESS, Status.FAILURE) and not runner.ended:
            if latched and status is Status.FAILURE:
                return stopped
            outcome, otherwise = ("success", "succeeded") if status is Status.SUCCESS else ("failure", "failed")
            end = End(outcome, self._teller.trace.why(status, state.time) or f"the tree {otherwise}")
            if self.reloader is None:
                return end
            self._rest(end)
        if latched and not runner.waits_for_reset and state.time - self._engine.supervisor.stops[-1].time > _AFTER_STOP:
            return stopped
        if state.time >= self._duration - DECISION_PERIOD / 2:
            return runner.ended or End("unfinished", f"the tree was still running after {self._duration:g} s")
        return None

    def _rest(self, end: End) -> None:
        """Wait for an edit: the tree has ended, and the run goes on."""
        self._runner.rest(end)
        self._teller.tree_ended(end.outcome, "; waiting for an edit")
