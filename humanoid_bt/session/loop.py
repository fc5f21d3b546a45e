"""The loop of a run, one tick at a time, and how it ends."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import replace
from typing import Protocol

from py_trees.common import Status

from humanoid_bt.core.clock import DECISION_PERIOD
from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Command, Mode, Pause, Percept, State
from humanoid_bt.session.debugger import Debugger
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.outcome import End, failed
from humanoid_bt.session.pace import Pace
from humanoid_bt.session.tick_watch import TickWatch
from humanoid_bt.session.tree_runner import TreeRunner

_ENDED = (Status.SUCCESS, Status.FAILURE)
_STOPPED = (Mode.EMERGENCY_STOP, Mode.DAMP)


class Successor(Protocol):
    """Puts other trees in the place of the one that runs, or has ended: the run goes on after its tree."""

    def look(self) -> None:
        """Do so if there is another one. To be called between two ticks."""


class Loop:
    """Ticks the tree until its end.

    Args:
        engine: control, plant and perception.
        runner: what runs the tree.
        debugger: says when the tree stands still, and who is told what happens.
        pace: how fast simulated time goes.
        ticks: watches how long ticks take.

    Attributes:
        limit: longest time from the first tick on [s].
        waits: whether an emergency stop is waited for, until its reset; else it ends the run.
        successor: puts other trees in the tree's place; None if the run ends with it.
        state: what the last tick saw, None before the first.
        command: what the last tick that was whole commanded.
        began: engine time of the first tick [s]; in realtime mode control has run for a while by then.
        began_at: when that was on the monotonic clock [s].
    """

    def __init__(self, engine: Engine, runner: TreeRunner, debugger: Debugger, pace: Pace, ticks: TickWatch) -> None:
        self._engine, self._runner, self._debugger, self._pace = engine, runner, debugger, pace
        self._teller, self._ticks = debugger.teller, ticks
        self._held: Pace | None = None  # how fast time goes while control holds the robot for a pause
        self.limit, self.waits = math.inf, False
        self.successor: Successor | None = None
        self.state: State | None = None
        self.command = Command(0, 0.0)
        self.began = self.began_at = 0.0

    def tick(self) -> End | None:
        """Let the time since the last tick pass, then tick the tree; return how the run ends, None if it goes on.

        While the run is paused, what the tick commands is withheld until the next one.

        Raises:
            ControlLost: control is gone.
        """
        runner, teller = self._runner, self._teller
        if self._held is not None and runner.status in _ENDED and not runner.ended and self.state is not None:
            return self._end(self.state, None)  # the tree has ended, and only now may the run
        state, percepts = self._sense() if self._held is None else self._release()
        self._ticks.begin()
        command, end = None, None
        try:
            self.command = command = runner.tick(state, percepts)
        except HumanoidBtError as error:
            end = failed(error)
        finally:
            slow = self._ticks.finish(state.time)
        if slow:
            teller.event("warning", slow)
        if command is None:
            teller.ticked(runner, state, percepts, None, self._ticks.took)
            return end
        self._debugger.ticked(runner)
        self._debugger.tell()
        pause = self._debugger.pause
        if pause is not None:
            command = self._hold(pause)
        return self._finish(state, percepts, command, pause, self._ticks.took)

    def stand_still(self, pause: Pause) -> End | None:
        """Let a tick's time pass without a tick: control holds the robot; return as :meth:`tick`.

        Raises:
            ControlLost: control is gone.
        """
        state, percepts = self._sense()
        self._runner.robot.stand_still(state, percepts)
        return self._finish(state, percepts, self._hold(pause), pause)

    def _sense(self) -> tuple[State, Mapping[str, Percept]]:
        """Let the time since the last tick pass, and look."""
        engine, teller, first = self._engine, self._teller, self.state is None
        if first:
            teller.warn_of_percepts(self._runner.tree)
        else:
            engine.advance()
            (self._held or self._pace).keep(engine.clock.now())
            if self.successor is not None and self._held is None:
                self.successor.look()
        with self._ticks.awaiting("the percept sources"):
            state, percepts = engine.sense()
        self.state = state
        if first:
            self.began, self.began_at = state.time, time.monotonic()
        teller.happened(state)
        self._debugger.tell()
        return state, percepts

    def _finish(
        self,
        state: State,
        percepts: Mapping[str, Percept],
        command: Command,
        pause: Pause | None,
        took: float = 0.0,
    ) -> End | None:
        """Give a tick's command to control unless the run ends, then tell of it."""
        self._teller.trace.tick(state, command)
        end = self._end(state, pause)
        if end is None:
            self._engine.submit(command)  # before anybody is told of it
        self._teller.ticked(self._runner, state, percepts, command, took)
        return end

    def _hold(self, pause: Pause) -> Command:
        """Return the command with which control holds the robot, in place of what the tree wants."""
        if self._held is None:
            self._held = self._pace if self._pace.speed else Pace(1.0 if self._debugger.attended else None)
        return replace(self._runner.robot.release_all(), pause=pause)

    def _release(self) -> tuple[State, Mapping[str, Percept]]:
        """Let what the last tick commanded be in force again, as if nothing had been since; then as :meth:`_sense`."""
        robot = self._runner.robot
        self._engine.submit(robot.repeat(self.command))
        state, percepts = self._sense()
        while state.mode is Mode.PAUSED:  # control has not heard of it yet
            robot.stand_still(state, percepts)
            self._engine.submit(robot.repeat(self.command))
            state, percepts = self._sense()
        self._held = None
        return state, percepts

    def leave(self, outcome: str, reason: str) -> End:
        """Return how the run ends that somebody ends between two ticks."""
        return self._stopped(reason) or self._result() or End(outcome, reason)

    def _end(self, state: State, pause: Pause | None) -> End | None:
        """Return how the run ends after this tick, None if it goes on; in a pause the end of the tree is kept back."""
        runner = self._runner
        if state.mode in _STOPPED and (state.mode is Mode.DAMP or not self.waits):
            return self._stopped()
        if pause is None and not runner.ended and (end := self._result()) is not None:
            if self.successor is None:
                return self._stopped("the tree ended") or end
            self._rest(end, state.time)
        if state.time - self.began - runner.robot.clock.stood >= self.limit - DECISION_PERIOD / 2:
            return self._stopped("the time was up before a reset") or self._result() or self._unfinished()
        return None

    def _result(self) -> End | None:
        """Return how the tree ended, None if it has not."""
        status = self._runner.status
        if self._runner.ended or status not in _ENDED:
            return self._runner.ended
        return End("success" if status is Status.SUCCESS else "failure", self._teller.trace.why())

    def _stopped(self, why: str = "") -> End | None:
        """Return the end of a run whose robot is stopped for safety now, None if it is not.

        Args:
            why: why the run ends then, "" if because the robot is stopped.
        """
        state = self.state
        if state is None or state.mode not in _STOPPED:
            return None
        why = why or ("a fall ends the run" if state.mode is Mode.DAMP else "")
        return End("stopped", f"{state.stop_reason} ({state.stop_source})" + (f"; {why}" if why else ""))

    def _unfinished(self) -> End:
        """Return the end of a run whose time is up."""
        tip = self._runner.tip
        doing = f" at {getattr(tip, 'path', tip.name)!r} ({tip.feedback_message or 'running'})" if tip else ""
        more = "--duration (in Python duration=) lets it go on longer"
        if self.state is not None and self.state.mode is Mode.PROTECTIVE_STOP:
            more = f"the robot was in a protective stop: {self.state.stop_reason} ({self.state.stop_source})"
        return End("unfinished", f"the tree still ran after {self.limit:g} s{doing}; {more}")

    def _rest(self, end: End, time: float) -> None:
        """Wait for another tree: this one has ended, and the run goes on."""
        self._runner.rest(end, time)
        self._teller.tree_ended(end.outcome, f"; {self._teller.resting}")
