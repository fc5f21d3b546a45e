"""The parts of one run, wired together: begun, ticked, ended."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, contextmanager, nullcontext, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

from humanoid_bt.core.ctrl_c import is_ctrl_c
from humanoid_bt.core.errors import ControlLost, UserError
from humanoid_bt.core.messages import Pause, Truth
from humanoid_bt.core.plain import plain
from humanoid_bt.decision.robot import Robot
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.link.run_folder import RunInfo
from humanoid_bt.perception.choice import sources_of
from humanoid_bt.perception.track import Track
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.record.folder import report_beside
from humanoid_bt.session.debugger import Debugger
from humanoid_bt.session.edits import Edits
from humanoid_bt.session.ending import Ending
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.goals import Goals, GoalTrees
from humanoid_bt.session.interrupt import WholeTick
from humanoid_bt.session.listener import Guarded, Listener
from humanoid_bt.session.loader import TreeLoader
from humanoid_bt.session.loop import Loop, Successor
from humanoid_bt.session.options import RunOptions, make_folder
from humanoid_bt.session.outcome import End, internal, report_of
from humanoid_bt.session.outside_parameters import OutsideParameters
from humanoid_bt.session.pace import Pace
from humanoid_bt.session.recording import RunRecorder, new_recorder, open_recorder
from humanoid_bt.session.reload import Reloader
from humanoid_bt.session.report import Report
from humanoid_bt.session.setup import run_setup
from humanoid_bt.session.teller import Teller
from humanoid_bt.session.tick_watch import TickWatch
from humanoid_bt.session.tree_runner import TreeRunner
from humanoid_bt.session.watch import Watch
from humanoid_bt.session.wiring import new_engine
from humanoid_bt.tree.ticking.executor import Executor, NodeChange
from humanoid_bt.tree.tree import Tree


class Drive:
    """A tree on a robot in a scene, ready to run once.

    Args:
        options: what to run.
        workspace: where names are looked up.
        listener: who is told what happens.
        recorder: takes what would be recorded, instead of a recorder that writes it as the options say.
        engine: what is loaded already and stands at the start; None to load what the options name.
        looks: whether somebody looks where a tick is that lasts, and Ctrl-C waits for its end.

    Attributes:
        engine: control, plant and perception.
        runner: what runs the tree.
        ticks: how long its ticks take.
        debugger: who paused it.
        end: how the run ends, None while it goes on.
        report: what happened, None until it is closed.
        begun: whether it was ever begun.

    Raises:
        UserError: the tree, robot, scene or a skill has mistakes, or a sink cannot be opened.
        NodeError: a skill raised an exception in ``setup``.
    """

    def __init__(
        self,
        options: RunOptions,
        workspace: Workspace,
        listener: Listener,
        recorder: RunRecorder | None = None,
        *,
        engine: Engine | None = None,
        looks: bool = True,
    ) -> None:
        self._options, self._listener = options, Guarded(listener)
        self._recorder: RunRecorder | None = recorder or new_recorder(options)
        loader = TreeLoader(options, workspace)
        self._files = loader.robot, loader.scene
        if options.numbered:
            make_folder()
        options.sinks.check()
        self.engine = engine or _engine(options, loader, workspace)
        self._teller = Teller(self._listener, self.engine, options.parameters)
        self.debugger = Debugger(self._teller)
        self.runner = TreeRunner(self._prepare(loader.first))
        self._pace = Pace(options.pace)
        self.ticks = TickWatch(looks)
        self.loop = Loop(self.engine, self.runner, self.debugger, self._pace, self.ticks)
        self._goal_trees = _goal_trees(options, self.engine, loader, self._prepare)
        edits = self._goal_trees or (Edits(loader, self._prepare) if options.watch else None)
        self._watch = Watch(edits) if edits is not None else None
        self._parameters = OutsideParameters(self.engine, self.runner, self.debugger)
        self._ending = Ending(self.engine, self.runner, self._teller, self._pace, self.ticks)
        self._stack: ExitStack | None = None
        self._process = os.getpid()
        self._tracks: Mapping[str, Track] | None = None
        self._asked = False  # somebody ends the run
        self._held: WholeTick | None = None  # what holds Ctrl-C back from many ticks at one go
        self.begun = False
        self.end: End | None = None
        self.report: Report | None = None

    def _prepare(self, tree: Tree) -> Executor:
        """Return what ticks a tree, set up. Edited trees are set up in another thread, while the old one runs."""
        engine = self.engine
        raise_estop, tells = engine.supervisor.raise_estop, self._teller.node_tells
        model, clock = engine.robot, engine.clock
        robot = Robot(model.config, clock, raise_estop, tells, lambda: engine.unseen, model=model, calls=engine.calls)
        teller, debugger = self._teller, self.debugger  # not self: whoever forgets a run shall be rid of it at once

        def changed(change: NodeChange) -> None:
            teller.node_changed(change)
            debugger.node_changed(change)

        executor = Executor(tree, robot, changed)
        executor.setup()
        return executor

    def _successor(self, watch: Watch) -> Successor:
        """Return what puts other trees in the first one's place: those of goals, or edited ones."""
        if self._goal_trees is not None:
            return Goals(self.engine, self._goal_trees, watch, self.runner, self._teller)
        return Reloader(watch, self.runner, self._teller)

    @property
    def running(self) -> bool:
        """Whether it can be ticked."""
        return self._stack is not None and self.end is None

    @property
    def tracks(self) -> Mapping[str, Track]:
        """What was seen up to the last tick, by name."""
        return self.runner.robot.tracks if self._tracks is None else self._tracks

    def start(self) -> None:
        """Open the recording, start what runs beside the tree.

        Raises:
            UserError: the recording or the view cannot be opened.
            HumanoidBtError: control did not come up.
        """
        self.begun = True
        with ExitStack() as stack:
            watched = False
            if self._recorder is not None:
                stack.enter_context(self._recorder)
                watched = self._open(self._recorder)
                self._teller.recorder = self._recorder
                self.engine.log_cycles()
            self.loop.limit = self._options.limit(watched, self.runner.tree)
            self.loop.waits = self._teller.waits = self._options.waits(watched)
            if self._recorder is not None:
                self._recorder.news(0.0, "limits", {"duration": plain(self.loop.limit), "waits": self.loop.waits})
            stack.enter_context(self.ticks)
            stack.callback(self.engine.close)
            with self.ticks.awaiting("the start of the run and of its percept sources"):
                self.engine.start(self._info(), self._options.log)
            if self._recorder is not None and (tables := self.engine.cycle_tables):
                self._recorder.follow(*tables)
            self._teller.begin()
            if self._watch is not None:
                self.loop.successor = self._successor(stack.enter_context(self._watch))
            self._stack = stack.pop_all()

    def tick(self) -> None:
        """Tick the tree once; what goes wrong is an end too.

        Raises:
            KeyboardInterrupt: Ctrl-C; a first one when the tick is over, a second one at once.
        """
        if (hold := self.engine.hold) is not None:
            self.stand_still(hold)
        else:
            self._go(self.loop.tick)

    def stand_still(self, pause: Pause) -> None:
        """Let a tick's time pass in which control holds the robot; raises as :meth:`tick`."""
        self._go(lambda: self.loop.stand_still(pause))

    @contextmanager
    def whole_ticks(self) -> Iterator[None]:
        """Hold Ctrl-C back from all the ticks within at one go, up to the end of each, which raises it."""
        with self._whole_tick() as held:
            self._held = held
            try:
                yield
            finally:
                self._held = None

    def _go(self, on: Callable[[], End | None]) -> None:
        if self._held is None:
            with self._whole_tick():
                self._do(on)
        else:
            self._do(on)
            self._held.over()

    def _do(self, on: Callable[[], End | None]) -> None:
        try:
            self._parameters.look()
            self.end = self._heard(on())
        except KeyboardInterrupt as interrupt:
            if is_ctrl_c(interrupt):
                self.end = self._ending.torn(interrupt)
            raise
        except ControlLost as error:
            self.end = self._ending.lost(error)
        except Exception as error:
            self.end = self._ending.bug(error)

    def _heard(self, end: End | None) -> End | None:
        """Return how the run ends, None if it goes on: by what the listener raised, if it raised anything."""
        failure = self._listener.failure
        return end if failure is None else internal(failure)

    @property
    def truth(self) -> Truth | None:
        """Where the robot really was at the last tick, None if nobody knows."""
        return self._teller.truth

    def keep_key(self, name: str, *value: Any) -> None:
        """Keep for a replay that a program set a key of the blackboard, or without a value that it deleted it."""
        self._teller.given("key", [name, *map(plain, value)])

    def leave(self, outcome: str, reason: str) -> None:
        """End the run between two ticks, unless it has ended."""
        self._asked = self._asked or outcome == "interrupted"
        self.end = self.end or self.loop.leave(outcome, reason)

    def close(self) -> None:
        """Bring the robot to a stand, close the recording, make the report. Twice is once.

        A process that was forked meanwhile has no part in the run, and closes nothing.

        Raises:
            KeyboardInterrupt: somebody does not wait for the end. All is closed, and the report is there, nevertheless;
                if not, because it came in between, whoever calls this again has both.
        """
        if (stack := self._stack) is None or os.getpid() != self._process:
            return
        moved, insists = self.loop.state is not None, False
        wall_time = time.monotonic() - self.loop.began_at if moved else 0.0
        self.end = self.end or self.loop.leave("unfinished", "the session was left while the tree was running")
        try:
            with stack:
                self._tracks = dict(self.runner.robot.tracks)
                insists = self._stand(self.end, moved)
                self.end = self._heard(self.end) or self.end
                rested = self.end is self.runner.ended  # the run went on after its tree, and ends as that did
                tree_ended = self.runner.ended_at if rested else self._ending.began
                self._teller.ended(self.end, tree_ended, self.ticks.to_dict())
        except KeyboardInterrupt:
            insists = True
            stack.close()  # the rest, if it came between two of what is closed
        missing = 0.0
        if self._recorder is not None:
            self._teller.recorder = None  # it is closed
            self._teller.news(self._recorder)
            missing = self._recorder.missing
        now = self.engine.clock.now()
        self.report = report_of(
            self.end,
            self.runner.tree,
            self.engine,
            trace=self._teller.trace,
            tracks=self.tracks,
            options=self._options,
            sim_time=(now if self._ending.began is None else self._ending.began) - self.loop.began,
            wall_time=wall_time,
            slow_ticks=self.ticks.to_dict(),
            recording_missing=missing,
            odometry=self._teller.odometry,
        )
        if self._options.numbered and self.report.recording_parts:
            with suppress(UserError):  # on a full disk, which is told
                self.report.write(report_beside(Path(self.report.recording_parts[0])))
        self.runner.robot.leave()
        self._stack = None
        if insists:
            raise KeyboardInterrupt

    def _stand(self, end: End, moved: bool) -> bool:
        """Bring the robot to a stand; return whether somebody pressed Ctrl-C meanwhile. A first one waits for it."""
        before = self._ending.interrupted
        try:
            with nullcontext() if self._asked else self._whole_tick():
                self.end = self._ending.bring_to_stand(end, moved)
        except KeyboardInterrupt:
            return True
        return self._ending.interrupted is not before

    def _whole_tick(self) -> AbstractContextManager[WholeTick | None]:
        """Return what holds Ctrl-C back until a tick is over."""
        return WholeTick(self.ticks.interrupted) if self.ticks.looks else nullcontext()

    def _info(self) -> RunInfo:
        """Return what runs, for other terminals."""
        tree, engine, recording = self.runner.tree, self.engine, self._options.sinks.file
        return RunInfo(
            tree.name,
            engine.robot.config.name,
            engine.scene.config.name,
            file=str(tree.path.absolute()) if tree.path.is_file() else "",
            recording=str(recording.absolute()) if recording else "",
        )

    def _open(self, recorder: RunRecorder) -> bool:
        """Open the recording; return whether anybody can watch."""
        tree, engine = self.runner.tree, self.engine
        setup = run_setup(tree, engine, self._options, *self._files)
        sinks = open_recorder(recorder, self._options, tree, engine, setup=setup, tell=self._listener.event)
        self._options = replace(self._options, sinks=sinks)
        if self._pace.speed is None and sinks.live and self._options.mode == "lockstep":
            self._pace.speed = 1.0
        return sinks.live


def _engine(options: RunOptions, loader: TreeLoader, workspace: Workspace) -> Engine:
    """Return what a run needs below its tree, loaded for it."""
    scene = Scene(load_scene(loader.scene), options.seed)
    sources = sources_of(options.perception, loader.first.perception, scene.config)
    return new_engine(options, loader.robot, scene, sources=sources, workspace=workspace)


def _goal_trees(
    options: RunOptions, engine: Engine, loader: TreeLoader, prepare: Callable[[Tree], Executor]
) -> GoalTrees | None:
    """Return what loads the tree of each goal, None where it starts with the run.

    Raises:
        UserError: the tree cannot be loaded for each, or is to be swapped for edited ones, too.
    """
    if not engine.takes_orders:
        return None
    if options.watch or isinstance(options.tree, Tree):
        what = "'watch' does not go" if options.watch else "a tree that is loaded already does not go"
        raise UserError(f"{what} with the action of a gateway", hint="it loads the tree's file for every goal")
    return GoalTrees(loader, prepare)
