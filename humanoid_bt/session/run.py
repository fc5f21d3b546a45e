"""Running one tree to its end: tick, record, report; and bringing the robot to a stand whatever happens."""

from __future__ import annotations

import logging
import time
import traceback
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import asdict
from pathlib import Path
from typing import NamedTuple, Protocol

from py_trees.behaviour import Behaviour
from py_trees.common import Status

from humanoid_bt.clock import DECISION_PERIOD
from humanoid_bt.control.robots import load_robot
from humanoid_bt.errors import ControlLost, HumanoidBtError, Place, UserError, nearest, relative
from humanoid_bt.messages import Mode, State
from humanoid_bt.plant.perception import SimulatedPerception
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime.engine import Realtime
from humanoid_bt.record.events import Level
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.robot import Robot
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.happenings import Happenings
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.options import RunOptions, make_folder
from humanoid_bt.session.recording import cut_short, open_recorder
from humanoid_bt.session.report import Report, stops_of, timeline_of, versions
from humanoid_bt.session.trace import Trace
from humanoid_bt.skill_files import class_file, place_in_file
from humanoid_bt.tree.executor import Executor, NodeChange, NodeError
from humanoid_bt.tree.guards import EmergencyStop
from humanoid_bt.tree.load import load_tree
from humanoid_bt.tree.tree import Tree
from humanoid_bt.workspace import Workspace

_log = logging.getLogger(__name__)

DEFAULT_ROBOT, DEFAULT_SCENE = "humanoid", "empty"

_SETTLE_TIME = 5.0  # s that the robot gets to come to a stand after the tree's end
_STATUS_TICKS = 10  # ticks between two reports to whoever looks from outside
_AFTER_STOP = 2.0  # s after a latched stop until the run ends, if the tree goes on


class Listener(Protocol):
    """Who is told what happens during a run."""

    def node_changed(self, change: NodeChange) -> None:
        """A node's status changed."""

    def event(self, time: float, level: Level, text: str) -> None:
        """Something else happened."""

    def progress(self, time: float, running: str) -> None:
        """A tick is over; ``running`` is the deepest running node and what it says."""


class _End(NamedTuple):
    """How a run ended: the outcome, why, and of an exception: it in a few words, its traceback."""

    outcome: str
    reason: str
    failure: str = ""
    traceback: str = ""


class Run:
    """A tree on a robot in a scene, ready to run once.

    Args:
        options: what to run.
        workspace: where names are looked up.
        listener: who is told what happens.

    Raises:
        UserError: the tree, robot, scene or a skill has mistakes, or a sink cannot be opened.
        NodeError: a skill raised an exception in ``setup``.

    Attributes:
        tree: what runs.
    """

    def __init__(self, options: RunOptions, workspace: Workspace, listener: Listener) -> None:
        self._options, self._listener = options, listener
        self.tree = load_tree(workspace.find_tree(options.tree), workspace, options.overrides)
        _refuse_subtree(self.tree)
        robot_path = workspace.find_robot(options.robot or self.tree.robot or DEFAULT_ROBOT)
        scene_path = workspace.find_scene(options.scene or self.tree.scene or DEFAULT_SCENE)
        self._scene = Scene(load_scene(scene_path), options.seed)
        if options.sinks.file is not None:
            make_folder(options.sinks.file)
        options.sinks.check()
        self._engine = self._new_engine(robot_path)
        self._recorder: Recorder | None = None
        self._robot = Robot(self._engine.robot.config, self._engine.clock, self.raise_estop, self._node_tells)
        self._executor = Executor(self.tree, self._robot, self._on_change)
        self._executor.setup()
        self._guards = [node.behaviour for node in self.tree.nodes if isinstance(node.behaviour, EmergencyStop)]
        self._trace = Trace(self._scene)
        self._happenings = Happenings(self._engine)
        self._pace = options.pace
        self._began = 0.0
        self._ticks = 0
        self._ended_at: float | None = None

    def _new_engine(self, robot_path: Path) -> Engine:
        options = self._options
        robot, start = load_robot(robot_path)
        if options.mode == "realtime":
            log = options.sinks.file.with_suffix(".control.log") if options.sinks.file else None
            return Realtime(robot, self._scene, self.tree.name, log, options.hold)
        return Lockstep(robot, start, self._scene, SimulatedPerception(self._scene, options.seed))

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
        return self._robot.config.name

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
                self._recorder = stack.enter_context(self._open_recorder())
            stack.callback(self._engine.close)
            self._engine.start()
            self._began = time.monotonic()
            end = self._run(interrupted)
            wall_time = time.monotonic() - self._began
        problem = cut_short(self._options.sinks.file)
        if problem:
            self._listener.event(self._now, "error", problem)
        return self._report(end, wall_time)

    def _run(self, interrupted: Callable[[], str]) -> _End:
        try:
            self._warn_of_percepts()
            return self._finish(self._tick_to_end(interrupted))
        except KeyboardInterrupt as error:
            return _End("interrupted", f"stopped at once{self._where(error)}")
        except ControlLost as error:
            return self._lost(error)
        except Exception as error:
            failure = f"internal error: {type(error).__name__}: {error}"
            end = _End("error", failure, failure, traceback.format_exc())
        self._recorder = None  # it may be what failed; it is closed all the same
        try:
            return self._finish(end)
        except ControlLost as error:
            self._listener.event(self._now, "error", str(error))
            return end
        except Exception:
            _log.exception("the robot could not be brought to a stand")
            return end

    def _lost(self, error: ControlLost) -> _End:
        """Halt the tree: there is no robot any more that could be brought to a stand."""
        self._ended_at = self._now
        self._event("error", str(error))
        with suppress(HumanoidBtError):  # what ended the run is told, not what came of it
            self._executor.halt(str(error))
        return _End("error", str(error))

    # ---- while the tree runs --------------------------------------------------------------------------------------

    def _tick_to_end(self, interrupted: Callable[[], str]) -> _End:
        engine, executor = self._engine, self._executor
        while True:
            state, percepts = engine.sense()
            self._tell(state.time)
            try:
                command = executor.tick(state, percepts)
            except HumanoidBtError as error:
                return _failed(error)
            self._trace.tick(state, command)
            self._after_tick(state)
            end = self._end(state)
            if end is None and (reason := interrupted()):
                end = _End("interrupted", reason)
            if end is not None:
                self._trace.measure_hand(state)
                return end
            engine.advance(command)
            self._keep_pace()

    def _end(self, state: State) -> _End | None:
        latched = state.mode in (Mode.EMERGENCY_STOP, Mode.DAMP)
        stop = f"{state.stop_reason} ({state.stop_source})"
        status = self._executor.status
        if status is Status.SUCCESS:
            return _End("success", self._why(Status.SUCCESS) or "the tree succeeded")
        if status is Status.FAILURE:
            return _End("stopped", stop) if latched else _End("failure", self._why(status) or "the tree failed")
        waits = any(guard.waits for guard in self._guards)
        if latched and not waits and state.time - self._engine.supervisor.stops[-1].time > _AFTER_STOP:
            return _End("stopped", stop)
        if state.time >= self._options.duration - DECISION_PERIOD / 2:
            return _End("unfinished", f"the tree was still running after {self._options.duration:g} s")
        return None

    def _why(self, status: Status) -> str:
        """Return what the first node says that took a status in the last tick: it decided for those above it."""
        for change in self._trace.timeline:
            if change.time >= self._now and change.status is status and change.feedback:
                return f"{change.path.rsplit('/', 1)[-1]}: {change.feedback}"
        return ""

    def _after_tick(self, state: State) -> None:
        if self._recorder is not None:
            objects = {name: self._scene.object_position(name, state.time) for name in self._scene.config.objects}
            self._recorder.sample(state, self._robot.tracks, objects)
        tip = self._executor.tree.root.tip()
        running = f"{tip.name}: {tip.feedback_message}" if tip is not None else "coming to a stand"
        self._listener.progress(state.time, running)
        self._ticks += 1
        if self._ticks % _STATUS_TICKS == 1:
            self._publish(state, tip)

    def _publish(self, state: State, tip: Behaviour | None) -> None:
        """Tell ``humanoid-bt status`` and ``show --live`` what goes on."""
        self._engine.publish(
            {
                "time": state.time,
                "node": getattr(tip, "path", ""),
                "feedback": tip.feedback_message if tip is not None else "",
                "tick_rate": self._ticks / max(time.monotonic() - self._began, 1e-9),
                "percepts": {name: round(track.age, 3) for name, track in self._robot.tracks.items()},
            },
            self.tree,
        )

    def _keep_pace(self) -> None:
        if self._pace:
            ahead = self._now / self._pace - (time.monotonic() - self._began)
            if ahead > 0:
                time.sleep(ahead)

    # ---- after it -------------------------------------------------------------------------------------------------

    def _finish(self, end: _End) -> _End:
        """Halt the tree and let control bring the robot to rest, with nothing commanded any more."""
        self._ended_at = self._now
        if end.failure:
            self._engine.supervisor.request_stop("the tree", end.failure)
        end = self._halt(end)
        self._event("info" if end.outcome == "success" else "warning", f"the tree ended: {end.outcome}")
        engine = self._engine
        until = self._now + _SETTLE_TIME
        while self._now < until:
            engine.advance(self._robot.release_all())
            state, percepts = engine.sense()
            self._tell(state.time)
            self._robot.begin_tick(state, percepts)
            self._after_tick(state)
            if state.mode is Mode.DAMP and end.outcome not in ("stopped", "error"):
                end = _End("stopped", f"{state.stop_reason} ({state.stop_source}), after the tree had ended")
            if state.base_settled and state.mode is not Mode.DAMP:
                break
            self._keep_pace()
        if timing := engine.timing:
            late = f"{timing.missed} missed, {timing.late_p99:.0f} us late at the 99th percentile"
            self._event("info", f"the servo ran {timing.cycles} cycles: {late}")
        return end

    def _halt(self, end: _End) -> _End:
        """Halt the tree if it still runs; one that has ended keeps its result, for those who look at it."""
        if self._executor.status is not Status.RUNNING:
            return end
        try:
            self._executor.halt("the run ended")
        except HumanoidBtError as error:
            if end.outcome == "unfinished":
                return _failed(error)
            self._event("error", str(error))
        return end

    def _where(self, error: BaseException) -> str:
        """Return in which line of a skill an exception came, as " in FILE:LINE:COLUMN"; "" if in none."""
        for node in self.tree.nodes:
            file = class_file(node.type.cls) if node.kind == "skill" else None
            place: Place | None = place_in_file(error, file) if file else None
            if place is not None:
                return f" in {place}, in the node {node.path!r}"
        return ""

    # ---- telling --------------------------------------------------------------------------------------------------

    @property
    def _now(self) -> float:
        return self._engine.clock.now()

    def _tell(self, now: float) -> None:
        for happening in self._happenings.until(now):
            self._event(happening.level, happening.text, happening.time)

    def _event(self, level: Level, text: str, at: float | None = None) -> None:
        now = self._now if at is None else at
        self._listener.event(now, level, text)
        if self._recorder is not None:
            self._recorder.event(now, level, text)

    def _node_tells(self, source: str, level: Level, text: str) -> None:
        self._event(level, f"{text}  ({source})")

    def _on_change(self, change: NodeChange) -> None:
        self._trace.node_changed(change)
        self._listener.node_changed(change)
        if self._recorder is not None:
            self._recorder.node_changed(change.time, change.path, change.status.name, change.feedback)

    def _warn_of_percepts(self) -> None:
        """Say which percepts will never come: a tree may well wait for one, but most often it is a slip."""
        published = self._scene.config.percepts
        named = {
            name for node in self.tree.nodes for names in node.type.percepts(node.values).values() for name in names
        }
        for name in sorted(named - published.keys()):
            hint = nearest(name, published) or "it publishes none"
            self._event("warning", f"the scene {self.scene_name!r} publishes no percept {name!r} ({hint})")

    # ---- the recording and the report -----------------------------------------------------------------------------

    def _open_recorder(self) -> Recorder:
        recorder, live = open_recorder(self._options, self.tree, self._engine, self._listener.event)
        if self._pace is None and live and self._options.mode == "lockstep":
            self._pace = 1.0
        return recorder

    def _report(self, end: _End, wall_time: float) -> Report:
        file = self._options.sinks.file
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
            trace_hash=self._trace.digest,
            timeline=timeline_of(self._trace.timeline),
            hand_error=self._trace.hand_error,
            fell=any(stop.mode is Mode.DAMP for stop in self._engine.supervisor.stops),
            stops=stops_of(self._engine.supervisor.stops),
            external_force_max=self._engine.external_force_max,
            timing=asdict(self._engine.timing) if self._engine.timing else None,
            recording=str(file) if file else None,
            versions=versions(),
            traceback=end.traceback,
        )


def _refuse_subtree(tree: Tree) -> None:
    """Refuse a tree that is made for use in other trees.

    Raises:
        UserError: it is.
    """
    if tree.is_subtree:
        declared = tree.header.get("parameters") or {}
        needed = [name for name, value in declared.items() if isinstance(value, dict) and value.get("default") is None]
        given = "".join(f", {name}: ..." for name in needed)
        message = f"the tree {tree.name!r} does not run alone: it is made for use in other trees (subtree: true)"
        raise UserError(message, Place(relative(tree.path)), f"in another one: subtree: {{tree: {tree.name}{given}}}")


def _failed(error: HumanoidBtError) -> _End:
    if not isinstance(error, NodeError):
        return _End("error", str(error), str(error).splitlines()[0])
    name, cause = error.path.rsplit("/", 1)[-1], error.error
    failure = f"{name!r} raised {type(cause).__name__}: {cause}".splitlines()[0]
    return _End("error", str(error), failure, "".join(traceback.format_exception(cause)))
