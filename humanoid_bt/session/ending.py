"""What follows the end of a tree: the robot comes to a stand, whatever happens."""

from __future__ import annotations

import logging
from contextlib import suppress

from py_trees.common import Status

from humanoid_bt.core.errors import ControlLost, HumanoidBtError
from humanoid_bt.core.messages import Mode
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.outcome import End, failed, internal, where
from humanoid_bt.session.pace import Pace
from humanoid_bt.session.teller import Teller
from humanoid_bt.session.tick_watch import TickWatch
from humanoid_bt.session.tree_runner import SETTLE_TIME, TreeRunner

_HOW_TO_HURRY = "; the robot comes to a stand, and another Ctrl-C does not wait for it"
_log = logging.getLogger(__name__)


class Ending:
    """Halts the tree and lets control bring the robot to rest, with nothing commanded any more.

    Args:
        engine: control, plant and perception.
        runner: what runs the tree.
        teller: is told what happens.
        pace: how fast simulated time goes.
        ticks: watches how long it takes to halt the tree.

    Attributes:
        began: engine time at which the run ended [s], None before it; its tree may have ended long before.
        interrupted: what ended it at once, if anybody insisted.
    """

    def __init__(self, engine: Engine, runner: TreeRunner, teller: Teller, pace: Pace, ticks: TickWatch) -> None:
        self._engine, self._runner, self._teller, self._pace = engine, runner, teller, pace
        self._ticks = ticks
        self.began: float | None = None
        self.interrupted: KeyboardInterrupt | None = None
        self._final = self._bug = False

    def torn(self, interrupt: KeyboardInterrupt) -> End:
        """Return the end of a run that somebody insists on ending at once: control is left alone with the robot."""
        self.interrupted, self._final = interrupt, True
        left = self._engine.abandon()
        reason = f"stopped at once{where(interrupt, self._runner.tree)}"
        return End("interrupted", f"{reason}; {left}" if left else reason)

    def lost(self, error: ControlLost) -> End:
        """Halt the tree: there is no robot any more that could be brought to a stand."""
        self._final, self.began = True, self._engine.clock.now()
        self._teller.event("error", str(error))
        with suppress(HumanoidBtError):  # what ended the run is told, not what came of it
            self._runner.halt(str(error))
        return End("error", str(error))

    def bug(self, error: Exception) -> End:
        """Return the end of a run in which something raised that is no skill."""
        self._bug = True
        return internal(error)

    def bring_to_stand(self, end: End, moved: bool) -> End:
        """Halt the tree and let the robot come to rest.

        Args:
            end: how the run ends.
            moved: whether the tree was ticked at all.

        Returns:
            How it ends after all: what goes wrong here is part of it.
        """
        if self._final:
            return end
        try:
            return self._settle(end, moved)
        except KeyboardInterrupt as interrupt:
            return self.torn(interrupt)
        except ControlLost as error:
            if not self._bug:
                return self.lost(error)
            self._teller.event("error", str(error))
        except Exception as error:
            return self._once_more(error, end, moved)
        return end

    def _once_more(self, error: Exception, end: End, moved: bool) -> End:
        """Return how a run ends in which something raised while the robot was to come to rest."""
        if not self._bug:
            end = self.bug(error)
        elif self._teller.recorder is not None:
            self._teller.recorder = None  # it may be what fails; it is closed all the same
        else:
            _log.exception("the robot could not be brought to a stand")
            return end
        return self.bring_to_stand(end, moved)

    def _settle(self, end: End, moved: bool) -> End:
        engine, runner = self._engine, self._runner
        self.began = now = engine.clock.now()
        if end.failure:
            engine.supervisor.request_stop("the tree", end.failure)
        end = self._halt(end)
        if end is not runner.ended:
            self._teller.tree_ended(end.outcome, _HOW_TO_HURRY if end.outcome == "interrupted" else "")
        command = runner.robot.release_all() if moved else None
        until = now + SETTLE_TIME
        while command is not None and engine.clock.now() < until:
            engine.submit(command)
            engine.advance()
            state, percepts = engine.sense()
            self._teller.happened(state)
            command = runner.hold(state, percepts)
            self._teller.ticked(runner, state, percepts, command)
            if state.mode is Mode.DAMP and end.outcome not in ("stopped", "error"):
                end = End("stopped", f"{state.stop_reason} ({state.stop_source}), after the tree had ended")
            heard = not end.failure or state.mode is not Mode.RUN  # of the stop, which stands in the report
            if heard and state.base_settled and state.mode is not Mode.DAMP:
                break
            self._pace.keep(engine.clock.now())
        if timing := engine.timing:
            late = f"{timing.missed} missed, {timing.late_p99:.0f} us late at the 99th percentile"
            self._teller.event("info", f"the servo ran {timing.cycles} cycles: {late}")
            if timing.cable:
                self._teller.event("info", f"the cable to the plant: {timing.cable}")
        return end

    def _halt(self, end: End) -> End:
        """Halt the tree if it still runs; one that has ended keeps its result, for those who look at it."""
        if self._runner.status is not Status.RUNNING:
            return end
        self._ticks.begin()
        try:
            self._runner.halt("the run ended")
        except HumanoidBtError as error:
            if end.outcome == "unfinished":
                return failed(error)
            self._teller.event("error", str(error))
        finally:
            slow = self._ticks.finish(self._teller.now)
        if slow:
            self._teller.event("warning", slow)
        return end
