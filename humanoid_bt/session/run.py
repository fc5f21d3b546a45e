"""Running one tree to its end: tick, record, report; and bringing the robot to a stand whatever happens."""

from __future__ import annotations

import logging
import time
import traceback
from collections.abc import Callable
from contextlib import AbstractContextManager, ExitStack, suppress
from dataclasses import asdict

from py_trees.common import Status

from humanoid_bt.clock import DECISION_PERIOD
from humanoid_bt.errors import ControlLost, HumanoidBtError
from humanoid_bt.messages import Mode, State
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.record.events import Level
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.robot import Robot
from humanoid_bt.session.edits import Edits, EditSource
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.loader import TreeLoader
from humanoid_bt.session.options import RunOptions, make_folder
from humanoid_bt.session.outcome import End, failed, where
from humanoid_bt.session.recording import cut_short, open_recorder
from humanoid_bt.session.reload import Reloader
from humanoid_bt.session.report import Report, stops_of, timeline_of, versions
from humanoid_bt.session.runner import SETTLE_TIME, TreeRunner
from humanoid_bt.session.teller import Listener, Teller
from humanoid_bt.session.watch import Watch
from humanoid_bt.session.wiring import new_engine
from humanoid_bt.tree.executor import Executor
from humanoid_bt.tree.tree import Tree
from humanoid_bt.workspace import Workspace

_log = logging.getLogger(__name__)

_AFTER_STOP = 2.0  # s after a latched stop until the run ends, if the tree goes on


class Run:
    """A tree on a robot in a scene, ready to run once.

    Args:
        options: what to run.
        workspace: where names are looked up.
        listener: who is told what happens; nobody if None.
        watch: with ``options.watch``, turns what looks for edits, once per call, into what is asked for them after
            every tick.

    Raises:
        UserError: the tree, robot, scene or a skill has mistakes, or a sink cannot be opened.
        NodeError: a skill raised an exception in ``setup``.
    """

    def __init__(
        self,
        options: RunOptions,
        workspace: Workspace,
        listener: Listener | None = None,
        watch: Callable[[EditSource], AbstractContextManager[EditSource]] = Watch,
    ) -> None:
        listener = listener or Listener()
        self._options, self._listener = options, listener
        loader = TreeLoader(options, workspace)
        self._watch = watch(Edits(loader, self._prepare)) if options.watch else None
        self._scene = Scene(load_scene(loader.scene), options.seed)
        if options.sinks.file is not None:
            make_folder(options.sinks.file)
        options.sinks.check()
        self._engine = new_engine(options, loader.robot, self._scene, loader.first.name)
        self._teller = Teller(listener, self._engine)
        self._runner = TreeRunner(self._prepare(loader.first))
        self._reloader: Reloader | None = None
        self._pace = options.pace
        self._began = 0.0
        self._ended_at: float | None = None

    def _prepare(self, tree: Tree) -> Executor:
        """Return what ticks a tree, set up. Edited trees are set up in another thread, while the old one runs."""
        robot = Robot(self._engine.robot.config, self._engine.clock, self.raise_estop, self._teller.node_tells)
        executor = Executor(tree, robot, self._teller.node_changed)
        executor.setup()
        return executor

    @property
    def tree(self) -> Tree:
        """What runs."""
        return self._runner.tree

    @property
    def engine(self) -> Engine:
        """Control, plant and perception."""
        return self._engine

    @property
    def scene_name(self) -> str:
        """The scene's name."""
        return self._scene.config.name

    @property
    def robot_name(self) -> str:
        """The robot's name."""
        return self._engine.robot.config.name

    def raise_estop(self, source: str, reason: str) -> None:
        """Raise the emergency stop. From any thread, at any time after the start."""
        self._engine.supervisor.raise_estop(source, reason)

    def request_reset(self, source: str) -> None:
        """Ask for a reset of a latched stop; the answer comes as an event."""
        self._engine.request_reset(source)

    def execute(self, interrupted: Callable[[], str] = lambda: "") -> Report:
        """Run the tree to its end, bring the robot to a stand, close the recording.

        A report comes back whatever the tree, a skill or a person at the keyboard does.

        Args:
            interrupted: asked at every tick; a reason ends the run. It may also raise KeyboardInterrupt, as any
                code may: that ends the run at once.

        Raises:
            UserError: the recording or the view cannot be opened.
        """
        with ExitStack() as stack:
            if self._options.sinks.active:
                self._teller.recorder = stack.enter_context(self._open_recorder())
            stack.callback(self._engine.close)
            self._engine.start()
            self._began = time.monotonic()
            self._teller.begin()
            if self._watch is not None:
                self._reloader = Reloader(stack.enter_context(self._watch), self._runner, self._teller)
            end = self._run(interrupted)
            wall_time = time.monotonic() - self._began
        problem = cut_short(self._options.sinks.file)
        if problem:
            self._listener.event(self._now, "error", problem)
        return self._report(end, wall_time)

    def _run(self, interrupted: Callable[[], str]) -> End:
        try:
            self._teller.warn_of_percepts(self.tree)
            return self._finish(self._tick_to_end(interrupted))
        except KeyboardInterrupt as error:
            return End("interrupted", f"stopped at once{where(error, self.tree)}")
        except ControlLost as error:
            return self._lost(error)
        except Exception as error:
            failure = f"internal error: {type(error).__name__}: {error}"
            end = End("error", failure, failure, traceback.format_exc())
        self._teller.recorder = None  # it may be what failed; it is closed all the same
        try:
            return self._finish(end)
        except ControlLost as error:
            self._listener.event(self._now, "error", str(error))
            return end
        except Exception:
            _log.exception("the robot could not be brought to a stand")
            return end

    def _lost(self, error: ControlLost) -> End:
        """Halt the tree: there is no robot any more that could be brought to a stand."""
        self._ended_at = self._now
        self._teller.event("error", str(error))
        with suppress(HumanoidBtError):  # what ended the run is told, not what came of it
            self._runner.halt(str(error))
        return End("error", str(error))

    # ---- while the tree runs --------------------------------------------------------------------------------------

    def _tick_to_end(self, interrupted: Callable[[], str]) -> End:
        engine, runner, teller = self._engine, self._runner, self._teller
        while True:
            state, percepts = engine.sense()
            teller.happened(state.time)
            try:
                command = runner.tick(state, percepts)
            except HumanoidBtError as error:
                return failed(error)
            teller.trace.tick(state, command)
            teller.ticked(state, runner)
            end = self._end(state)
            if end is None and (reason := interrupted()):
                end = runner.ended or End("interrupted", reason)
            if end is not None:
                if end is not runner.ended:
                    teller.trace.measure_hand(state)
                return end
            engine.submit(command)
            engine.advance()
            self._keep_pace()
            if self._reloader is not None:
                self._reloader.look()

    def _end(self, state: State) -> End | None:
        """Return how the run ends after this tick, None if it goes on."""
        latched = state.mode in (Mode.EMERGENCY_STOP, Mode.DAMP)
        stopped = End("stopped", f"{state.stop_reason} ({state.stop_source})")
        runner, status = self._runner, self._runner.status
        if status in (Status.SUCCESS, Status.FAILURE) and not runner.ended:
            if latched and status is Status.FAILURE:
                return stopped
            outcome, otherwise = ("success", "succeeded") if status is Status.SUCCESS else ("failure", "failed")
            end = End(outcome, self._teller.trace.why(status, self._now) or f"the tree {otherwise}")
            if self._reloader is None:
                return end
            self._rest(end, state)
        if latched and not runner.waits_for_reset and state.time - self._engine.supervisor.stops[-1].time > _AFTER_STOP:
            return stopped
        if state.time >= self._options.duration - DECISION_PERIOD / 2:
            return runner.ended or End("unfinished", f"the tree was still running after {self._options.duration:g} s")
        return None

    def _rest(self, end: End, state: State) -> None:
        """Wait for an edit: the tree has ended, and the run goes on."""
        self._runner.rest(end)
        self._teller.trace.measure_hand(state)
        self._tell_end(end, "; waiting for an edit")

    def _tell_end(self, end: End, more: str = "") -> None:
        level: Level = "info" if end.outcome == "success" else "warning"
        self._teller.event(level, f"the tree ended: {end.outcome}{more}")

    def _keep_pace(self) -> None:
        if self._pace:
            ahead = self._now / self._pace - (time.monotonic() - self._began)
            if ahead > 0:
                time.sleep(ahead)

    # ---- after it -------------------------------------------------------------------------------------------------

    def _finish(self, end: End) -> End:
        """Halt the tree and let control bring the robot to rest, with nothing commanded any more."""
        self._ended_at = self._now
        if end.failure:
            self._engine.supervisor.request_stop("the tree", end.failure)
        end = self._halt(end)
        if end is not self._runner.ended:
            self._tell_end(end)
        engine, runner = self._engine, self._runner
        command = runner.robot.release_all()
        until = self._now + SETTLE_TIME
        while self._now < until:
            engine.submit(command)
            engine.advance()
            state, percepts = engine.sense()
            self._teller.happened(state.time)
            command = runner.hold(state, percepts)
            self._teller.ticked(state, runner)
            if state.mode is Mode.DAMP and end.outcome not in ("stopped", "error"):
                end = End("stopped", f"{state.stop_reason} ({state.stop_source}), after the tree had ended")
            if state.base_settled and state.mode is not Mode.DAMP:
                break
            self._keep_pace()
        if timing := engine.timing:
            late = f"{timing.missed} missed, {timing.late_p99:.0f} us late at the 99th percentile"
            self._teller.event("info", f"the servo ran {timing.cycles} cycles: {late}")
        return end

    def _halt(self, end: End) -> End:
        """Halt the tree if it still runs; one that has ended keeps its result, for those who look at it."""
        if self._runner.status is not Status.RUNNING:
            return end
        try:
            self._runner.halt("the run ended")
        except HumanoidBtError as error:
            if end.outcome == "unfinished":
                return failed(error)
            self._teller.event("error", str(error))
        return end

    @property
    def _now(self) -> float:
        return self._engine.clock.now()

    # ---- the recording and the report -----------------------------------------------------------------------------

    def _open_recorder(self) -> Recorder:
        recorder, live = open_recorder(self._options, self.tree, self._engine, self._listener.event)
        if self._pace is None and live and self._options.mode == "lockstep":
            self._pace = 1.0
        return recorder

    def _report(self, end: End, wall_time: float) -> Report:
        file = self._options.sinks.file
        engine, trace = self._engine, self._teller.trace
        return Report(
            tree=self.tree.name,
            robot=self.robot_name,
            scene=self.scene_name,
            seed=self._options.seed,
            parameters=dict(self.tree.parameters),
            outcome=end.outcome,
            reason=end.reason,
            sim_time=round(self._now if self._ended_at is None else self._ended_at, 3),
            wall_time=wall_time,
            trace_hash=trace.digest,
            timeline=timeline_of(trace.timeline),
            reloads=trace.reloads,
            hand_error=trace.hand_error,
            fell=any(stop.mode is Mode.DAMP for stop in engine.supervisor.stops),
            stops=stops_of(engine.supervisor.stops),
            external_force_max=engine.external_force_max,
            timing=asdict(engine.timing) if engine.timing else None,
            recording=str(file) if file else None,
            versions=versions(),
            traceback=end.traceback,
        )
