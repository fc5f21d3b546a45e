"""Running one tree to its end: tick, record, report; and bringing the robot to a stand whatever happens."""

from __future__ import annotations

import hashlib
import importlib.metadata
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from py_trees.common import Status

from humanoid_bt.clock import DECISION_PERIOD
from humanoid_bt.errors import HumanoidBtError, UserError, relative
from humanoid_bt.messages import SIDES, Command, HandTarget, Mode, Side, State
from humanoid_bt.plant.perception import SimulatedPerception
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.record.tree_view import TreeView
from humanoid_bt.robot import Robot
from humanoid_bt.session.lockstep import Lockstep, load_robot
from humanoid_bt.session.report import Report
from humanoid_bt.tree.executor import Executor, NodeChange
from humanoid_bt.tree.load import load_tree
from humanoid_bt.workspace import Workspace

DEFAULT_ROBOT, DEFAULT_SCENE = "humanoid", "empty"

_SETTLE_TIME = 5.0  # s that the robot gets to come to a stand after the tree's end
_AFTER_STOP = 2.0  # s after a latched stop until the run ends, if the tree goes on
_PACKAGES = ("humanoid-bt", "mujoco", "mink", "py_trees", "numpy", "rerun-sdk")


class Listener(Protocol):
    """Who is told what happens during a run."""

    def node_changed(self, change: NodeChange) -> None:
        """A node's status changed."""

    def event(self, time: float, level: str, text: str) -> None:
        """Something else happened; ``level`` is info, warning or error."""

    def progress(self, time: float, running: str) -> None:
        """A tick is over; ``running`` is the deepest running node and what it says."""


@dataclass(frozen=True)
class RunOptions:
    """What to run, and how.

    Attributes:
        tree: name or path of the tree.
        robot, scene: names or paths; None for what the tree says.
        overrides: parameter values as text.
        seed: of everything random.
        duration: longest simulated time [s].
        pace: simulated seconds per second; None for as fast as it can.
        sinks: where the recording goes.
    """

    tree: str
    robot: str | None = None
    scene: str | None = None
    overrides: Mapping[str, str] = field(default_factory=dict)
    seed: int = 0
    duration: float = 120.0
    pace: float | None = None
    sinks: Sinks = field(default_factory=Sinks)


class Run:
    """A tree on a robot in a scene, ready to run once.

    Args:
        options: what to run.
        workspace: where names are looked up.
        listener: who is told what happens.

    Raises:
        UserError: the tree, robot, scene or a skill has mistakes, or a sink cannot be opened.
    """

    def __init__(self, options: RunOptions, workspace: Workspace, listener: Listener) -> None:
        self._options, self._listener = options, listener
        tree_path = workspace.find_tree(options.tree)
        self.tree = load_tree(tree_path, workspace, options.overrides)
        robot_path = workspace.find_robot(options.robot or self.tree.robot or DEFAULT_ROBOT)
        scene_path = workspace.find_scene(options.scene or self.tree.scene or DEFAULT_SCENE)
        self._scene = Scene(load_scene(scene_path), options.seed)
        options.sinks.check()
        model, start = load_robot(robot_path)
        perception = SimulatedPerception(self._scene, options.seed)
        self._lockstep = Lockstep(model, start, self._scene, perception)
        self._robot = Robot(model.config, self._lockstep.clock)
        self._executor = Executor(self.tree, self._robot, self._on_change)
        self._executor.setup()
        self._timeline: list[NodeChange] = []
        self._hash = hashlib.sha256()
        self._told_stops = self._told_rejected = 0
        self._last_event = -1.0
        self._last_hand: tuple[Side, str] | None = None
        self._hand_error: float | None = None
        self._recorder: Recorder | None = None
        self._state: State | None = None
        self.view_url = ""

    @property
    def scene_name(self) -> str:
        """The scene's name."""
        return self._scene.config.name

    @property
    def robot_name(self) -> str:
        """The robot's name."""
        return self._robot.config.name

    def execute(self, interrupted: Callable[[], str] = lambda: "") -> Report:
        """Run the tree to its end, bring the robot to a stand, close the recording.

        Args:
            interrupted: asked at every tick; a reason ends the run.
        """
        began = time.monotonic()
        with ExitStack() as stack:
            if self._options.sinks.active:
                self._recorder = stack.enter_context(self._open_recorder())
                self.view_url = self._recorder.url
            outcome, reason = self._tick_to_end(interrupted, began)
            sim_time = self._lockstep.clock.now()
            self._event("info" if outcome == "success" else "warning", f"the tree ended: {outcome}: {reason}")
            self._come_to_stand(reason)
        return self._report(outcome, reason, sim_time, time.monotonic() - began)

    # ---- while the tree runs --------------------------------------------------------------------------------------

    def _tick_to_end(self, interrupted: Callable[[], str], began: float) -> tuple[str, str]:
        lockstep, executor = self._lockstep, self._executor
        while True:
            state, percepts = lockstep.sense()
            self._state = state
            try:
                command = executor.tick(state, percepts)
            except HumanoidBtError as error:
                lockstep.controller.supervisor.request_stop("the tree", str(error).splitlines()[0])
                return "error", str(error)
            self._after_tick(state, command)
            ended = self._end(state) or self._interruption(interrupted())
            if ended:
                return ended
            lockstep.advance(command)
            self._pace(began)

    def _end(self, state: State) -> tuple[str, str] | None:
        latched = state.mode in (Mode.EMERGENCY_STOP, Mode.DAMP)
        stop = f"{state.stop_reason} ({state.stop_source})"
        root = self._executor.tree.root
        if root.status is Status.SUCCESS:
            self._measure_hand(state)
            return "success", root.feedback_message or "the tree succeeded"
        if root.status is Status.FAILURE:
            return ("stopped", stop) if latched else ("failure", self._why_failed())
        if latched and state.time - self._lockstep.controller.supervisor.stops[-1].time > _AFTER_STOP:
            return "stopped", stop
        if state.time >= self._options.duration - DECISION_PERIOD / 2:
            self._measure_hand(state)
            return "unfinished", f"the tree was still running after {self._options.duration:g} s"
        return None

    @staticmethod
    def _interruption(reason: str) -> tuple[str, str] | None:
        return ("interrupted", reason) if reason else None

    def _why_failed(self) -> str:
        """Return what the deepest node says that failed in the last tick."""
        now = self._lockstep.clock.now()
        for change in self._timeline:
            if change.time >= now and change.status is Status.FAILURE and change.feedback:
                return f"{change.path.rsplit('/', 1)[-1]}: {change.feedback}"
        return "the tree failed"

    def _after_tick(self, state: State, command: Command) -> None:
        self._digest(state, command)
        self._follow_hand(command)
        self._tell_events(state.time)
        if self._recorder is not None:
            self._recorder.sample(state, self._robot.tracks, self._object_positions(state.time))
        tip = self._executor.tree.root.tip()
        running = f"{tip.name}: {tip.feedback_message}" if tip is not None else ""
        self._listener.progress(state.time, running)

    def _digest(self, state: State, command: Command) -> None:
        for values in (state.joint_positions, state.joint_velocities, state.setpoint_positions, state.base_position):
            self._hash.update(values.tobytes())
        self._hash.update(f"{state.cycle} {state.mode.value} {sorted(command.sources.items())}".encode())

    def _follow_hand(self, command: Command) -> None:
        """Remember which hand goes for which object: the one nearest to the hand's target."""
        for side in SIDES:
            target = command.targets.get(f"{side}_hand")
            positions = self._object_positions(command.stamp)
            if isinstance(target, HandTarget) and positions:
                aim = target.position
                nearest = min(positions, key=lambda name: float(np.linalg.norm(positions[name] - aim)))
                self._last_hand = (side, nearest)

    def _measure_hand(self, state: State) -> None:
        if self._last_hand is not None:
            side, thing = self._last_hand
            offset = state.hands[side] - self._scene.object_position(thing, state.time)
            self._hand_error = float(np.linalg.norm(offset))

    def _object_positions(self, now: float) -> dict[str, Any]:
        return {name: self._scene.object_position(name, now) for name in self._scene.config.objects}

    def _tell_events(self, now: float) -> None:
        supervisor = self._lockstep.controller.supervisor
        for stop in supervisor.stops[self._told_stops :]:
            self._event("error", f"{stop.mode.value.replace('_', ' ')}: {stop.reason} ({stop.source})")
        self._told_stops = len(supervisor.stops)
        for text in supervisor.rejected[self._told_rejected :]:
            self._event("warning", f"rejected {text}")
        self._told_rejected = len(supervisor.rejected)
        for at, text in self._scene.events(self._last_event, now):
            self._event("info", f"scene: {text}", at)
        self._last_event = now

    def _event(self, level: str, text: str, at: float | None = None) -> None:
        now = self._lockstep.clock.now() if at is None else at
        self._listener.event(now, level, text)
        if self._recorder is not None:
            self._recorder.event(now, level, text)  # type: ignore[arg-type]

    def _on_change(self, change: NodeChange) -> None:
        self._timeline.append(change)
        self._hash.update(f"{change.time} {change.path} {change.status.name}".encode())
        self._listener.node_changed(change)
        if self._recorder is not None:
            self._recorder.node_changed(change.time, change.path, change.status.name, change.feedback)

    def _pace(self, began: float) -> None:
        if self._options.pace:
            ahead = self._lockstep.clock.now() / self._options.pace - (time.monotonic() - began)
            if ahead > 0:
                time.sleep(ahead)

    # ---- after it -------------------------------------------------------------------------------------------------

    def _come_to_stand(self, reason: str) -> None:
        """Halt the tree and let control bring the robot to rest, with nothing commanded any more."""
        lockstep = self._lockstep
        try:
            self._executor.halt(reason)
        except HumanoidBtError as error:
            self._event("error", str(error))
        until = lockstep.clock.now() + _SETTLE_TIME
        while lockstep.clock.now() < until:
            lockstep.advance(self._robot.release_all())
            state, percepts = lockstep.sense()
            self._robot.begin_tick(state, percepts)
            self._state = state
            self._tell_events(state.time)
            if self._recorder is not None:
                self._recorder.sample(state, self._robot.tracks, self._object_positions(state.time))
            if state.base_settled and state.mode is not Mode.DAMP:
                break

    def _open_recorder(self) -> Recorder:
        tree, options = self.tree, self._options
        info = {
            "tree": tree.name,
            "robot": self.robot_name,
            "scene": self.scene_name,
            "seed": str(options.seed),
            "parameters": ", ".join(f"{name} = {value}" for name, value in tree.parameters.items()),
            "versions": ", ".join(f"{name} {version}" for name, version in versions().items()),
        }
        return Recorder(
            self._lockstep.plant.model,
            self._lockstep.robot.joint_names,
            self._robot.config,
            tree=TreeView(tree.nodes, tree.source, relative(tree.path)),
            sinks=options.sinks,
            info=info,
        )

    def _report(self, outcome: str, reason: str, sim_time: float, wall_time: float) -> Report:
        supervisor = self._lockstep.controller.supervisor
        file = self._options.sinks.file
        return Report(
            tree=self.tree.name,
            robot=self.robot_name,
            scene=self.scene_name,
            seed=self._options.seed,
            parameters=dict(self.tree.parameters),
            outcome=outcome,
            reason=reason,
            sim_time=round(sim_time, 3),
            wall_time=wall_time,
            trace_hash=self._hash.hexdigest(),
            timeline=[
                {"time": round(c.time, 3), "path": c.path, "status": c.status.name, "feedback": c.feedback}
                for c in self._timeline
            ],
            hand_error=self._hand_error,
            fell=any(stop.mode is Mode.DAMP for stop in supervisor.stops),
            stops=[
                {
                    "time": stop.time,
                    "mode": stop.mode.value,
                    "reason": stop.reason,
                    "source": stop.source,
                    "commanded_by": dict(stop.resources),
                }
                for stop in supervisor.stops
            ],
            external_force_max=self._lockstep.plant.external_force_max,
            recording=str(file) if file else None,
            versions=versions(),
        )


def versions() -> dict[str, str]:
    """Return the versions of the packages that a run depends on."""
    found: dict[str, str] = {}
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "unknown"
    return found


def default_recording(tree: str) -> Path:
    """Return where a run is recorded by default: a new file in ``runs/`` below the working directory, which is made.

    Raises:
        UserError: the folder cannot be made.
    """
    folder = Path("runs")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        hint = "give another place with --record FILE, or --no-record"
        raise UserError(f"the folder {str(folder.absolute())!r} cannot be made: {error.strerror}", hint=hint) from error
    stamp = time.strftime("%Y%m%d-%H%M%S")
    name = Path(tree).stem
    path = folder / f"{name}-{stamp}.rrd"
    number = 2
    while path.exists():
        path = folder / f"{name}-{stamp}-{number}.rrd"
        number += 1
    return path
