"""The recorder: everything a run shows, into one rerun recording. It works in a process of its own.

Recording is cheap because a sample only keeps references: all encoding happens in batches.
"""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import mujoco
import numpy as np

from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.messages import Array, State
from humanoid_bt.decision.result import Reported
from humanoid_bt.perception.track import Track
from humanoid_bt.plant.rendering import View
from humanoid_bt.record.blueprint import blueprint
from humanoid_bt.record.camera import HeadCamera
from humanoid_bt.record.documents import send_info, send_tree_file
from humanoid_bt.record.events import EventLog, Level
from humanoid_bt.record.eye import Eye
from humanoid_bt.record.flight import Flight
from humanoid_bt.record.lanes import Lanes
from humanoid_bt.record.outlet import Announce, Outlet, tell_nothing
from humanoid_bt.record.overlays import Overlays
from humanoid_bt.record.parted_file import Tell, tell_nobody
from humanoid_bt.record.plots import Plots
from humanoid_bt.record.results import ResultSeries
from humanoid_bt.record.route_view import RouteView
from humanoid_bt.record.scene_view import SceneView
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.record.stop_sign import StopSign
from humanoid_bt.record.subject import TreeView, Wanted
from humanoid_bt.record.tree_view import TreeStatus
from humanoid_bt.record.viewers import FLUSH_TIMEOUT
from humanoid_bt.robot.config import RobotConfig

_LIVE_BATCH = 0.5  # time covered by a batch while somebody watches [s]
_FILE_BATCH = 2.0  # the same of a file alone: fewer and larger batches take less room and time [s]
_LOCKSTEP_BATCH = 5.0  # the same of a run that another one repeats to the bit [s]
_FRAME = 0.04  # time between poses of the 3D view [s]: 25 a second look fluent at half the cost of every tick
_CONTROL_ENDS = 30.0  # s that control may take to bring the robot to a stand when decision is gone
_SLACK = 1e-6  # times are sums of periods


class Recorder:
    """Records one run and shows it live.

    Call :meth:`sample` once per tick and the others when something happens, in the order of time. Use it as
    a context manager, or close it: after that the file is whole.

    Args:
        model: the whole scene; the robot's qpos comes first: free base, then joints in the order of ``joint_names``.
            Scene objects are bodies named ``object_<name>``.
        joint_names: the robot's joints.
        config: the robot's numbers.
        tree: what is shown of the tree.
        sinks: where the recording goes.
        info: about the run, to be read by people: heading -> text, such as tree, robot, seed, parameters.
        setup: what is run, as data for JSON: all it takes to run it again.
        camera: what the head camera has in the picture.
        pictures: whether there shall be pictures of it.
        busy_cores: how many cores the run itself needs; pictures need another.
        announce: is told what :meth:`close` waits for, and for how long at most [s].
        tell: is told what becomes of the file, such as that another one follows.

    Attributes:
        written: engine time up to which the file has everything [s]; -inf if it has nothing, or is gone.

    Raises:
        UserError: a sink cannot be opened, or pictures are insisted on and there is no OpenGL.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        joint_names: tuple[str, ...],
        config: RobotConfig,
        *,
        tree: TreeView,
        sinks: Sinks,
        info: Mapping[str, str],
        setup: Mapping[str, Any] | None = None,
        camera: View,
        pictures: Wanted = False,
        busy_cores: int = 1,
        announce: Announce = tell_nothing,
        tell: Tell = tell_nobody,
    ) -> None:
        self._scene = SceneView(model, len(joint_names), config.base)
        self._eye = Eye(self._scene.base_height, self._scene.heights)
        self._overlays = Overlays(config.sole)
        self._routes = RouteView()
        self._stop_sign = StopSign(self._scene.base_height)
        self._plots = Plots(model, joint_names, config)
        self._tree = TreeStatus(tree.outline)
        self._lanes = Lanes(tree.outline)
        self._events = EventLog(tree.outline)
        self._results = ResultSeries()
        self._flight = Flight(joint_names, setup or {})
        self._views = (self._scene, self._overlays, self._routes, self._stop_sign, self._plots, self._tree)
        self._last_flush = self._last_frame = self._last_truth = self._sampled = -np.inf
        self.written = -np.inf
        self._closed = False
        self._announce = announce
        self._live = sinks.live
        self._outlet = Outlet(sinks, info.get("tree", tree.file) or "run", self._layout(), announce, tell)
        try:
            self._camera = HeadCamera(model, camera, pictures, busy_cores)
            for part in (*self._views, self._camera, self._flight):
                part.log_static(self._outlet.stream)
            send_info(self._outlet.stream, 0.0, info)
            send_tree_file(self._outlet.stream, 0.0, tree)
            self._outlet.settle()
        except BaseException:
            self._outlet.close()
            raise

    @property
    def url(self) -> str:
        """Address of the web viewer, "" if none is served."""
        return self._outlet.url

    @property
    def follows(self) -> bool:
        """Whether it takes servo cycles by itself, from a control that goes on whatever the run does."""
        return self._flight.follows

    @property
    def control_lives(self) -> bool:
        """Whether there is a control from which it takes servo cycles by itself, and which still writes them."""
        return self._flight.control_lives

    @property
    def _batch(self) -> float:
        """Time that a batch covers [s]."""
        if self._live:
            return _LIVE_BATCH
        return _FILE_BATCH if self.follows else _LOCKSTEP_BATCH

    @property
    def trouble(self) -> str:
        """What is wrong with the file, or missing in it, "" while nothing is."""
        return self._outlet.trouble or self._flight.trouble

    def truth(self, time: float, pose: Sequence[float]) -> None:
        """Record where the base really is, of which control knows nothing.

        Args:
            time: [s].
            pose: world frame, seven numbers.
        """
        if time - self._last_truth >= _FRAME - _SLACK:
            self._last_truth = time
            self._scene.add_truth(time, np.array(pose))

    def routes(self, time: float, routes: Sequence[Sequence[Sequence[float]]]) -> None:
        """Record the ways that are followed from a time on.

        Args:
            time: [s].
            routes: points x, y of each, world frame [m].
        """
        self._routes.add_routes(time, [np.array(route) for route in routes])

    def sample(
        self,
        state: State,
        tracks: Mapping[str, Track],
        objects: Mapping[str, Array],
        hidden: Container[str] = (),
        tick: bytes = b"",
    ) -> None:
        """Record one tick.

        Args:
            state: what control knows.
            tracks: percepts by name, placed in the world.
            objects: true positions of scene objects by name, world frame, shape (3,) [m].
            hidden: names of those that perception cannot see now.
            tick: what decision saw and commanded, to the bit: an encoded :class:`~humanoid_bt.record.tick.Tick`.
        """
        self._check_open()
        if tick:
            self._flight.tick(state.time, tick)
        self._sampled = state.time
        try:
            self._show(state, dict(tracks), objects, hidden)
        finally:
            if self._last_flush == -np.inf:
                self._last_flush = state.time
            if state.time - self._last_flush >= self._batch - _SLACK:
                self._last_flush = state.time
                self.write()

    def _show(
        self, state: State, seen: Mapping[str, Track], objects: Mapping[str, Array], hidden: Container[str]
    ) -> None:
        """Take what is shown of a tick."""
        self._plots.add(state, seen)
        self._lanes.add(state)
        if state.time - self._last_frame >= _FRAME - _SLACK:
            self._last_frame = state.time
            self._scene.add(state, objects, hidden)
            self._camera.add(state, objects, hidden)
            self._overlays.add(state, seen)
            self._routes.add(state, seen)
            self._stop_sign.add(state)
            self._eye.add(state, seen, objects, self._routes.latest)  # last: it computes, and may fail

    def cycles(self, plans: Array, cycles: Array) -> None:
        """Record servo cycles, as :class:`~humanoid_bt.control.cycle_log.CycleLog` keeps them.

        Args:
            plans: rows of plans of the whole body.
            cycles: rows of servo cycles.
        """
        self._check_open()
        self._flight.add(plans, cycles)

    def follow(self, plans: Path, cycles: Path) -> None:
        """Record the servo cycles in these tables from now on.

        Raises:
            LinkError: they are not there.
        """
        self._check_open()
        self._flight.follow(plans, cycles)

    def news(self, time: float, kind: str, value: Any) -> None:
        """Keep something that happened for those who read the recording, without showing it.

        Args:
            time: engine time [s].
            kind: what it is.
            value: data for JSON.
        """
        self._check_open()
        self._flight.news(time, kind, value)

    def node_changed(self, time: float, path: str, status: str, feedback: str) -> None:
        """Record that a node's status changed.

        Args:
            time: engine time [s].
            path: the node's path.
            status: RUNNING, SUCCESS, FAILURE or INVALID.
            feedback: what the node says about it.
        """
        self._check_open()
        self._flight.news(time, "node", [path, status, feedback])
        self._tree.change(time, path, status, feedback)
        self._lanes.change(time, path, status)
        self._events.node_changed(time, path, status, feedback)

    def results(self, time: float, path: str, results: Sequence[Reported]) -> None:
        """Record what a skill has reported by now.

        Args:
            time: engine time [s].
            path: the node's path.
            results: what it has set.
        """
        self._check_open()
        self._flight.news(time, "results", [path, [list(result) for result in results]])
        self._results.add(time, path, results)

    def show_tree(self, time: float, tree: TreeView, info: Mapping[str, str]) -> None:
        """Record that another tree takes the place of the one so far.

        Args:
            time: engine time [s].
            tree: what is shown of it.
            info: about the run from now on, as at its start.
        """
        self._check_open()
        for part in (self._tree, self._lanes):
            part.show(time, tree.outline)
        self._events.show(tree.outline)
        send_tree_file(self._outlet.stream, time, tree)
        send_info(self._outlet.stream, time, info)

    def event(self, time: float, level: Level, text: str) -> None:
        """Record something that happened.

        Args:
            time: engine time [s].
            level: info, warning or error.
            text: what happened.
        """
        self._check_open()
        self._flight.news(time, "event", [level, text])
        self._events.event(time, level, text)

    def save(self) -> None:
        """Write what is kept exactly since the last time: it is what must not be lost."""
        if not self._closed and self._flight.flush(self._outlet.stream):
            self._note(self._sampled, self._outlet.settle())

    def write(self) -> None:
        """Write what was recorded since the last batch, and go on in another file if this one is large enough."""
        self.flush()
        self._outlet.go_on(max(self._sampled, 0.0))

    def flush(self) -> None:
        """Write what was recorded since the last batch; does nothing after :meth:`close`."""
        if self._closed:
            return
        stream = self._outlet.stream
        if why := self._camera.take_news():
            self._events.event(max(self._last_flush, 0.0), "info", f"no picture of the head camera: {why}")
        for part in (*self._views, self._lanes, self._results, self._eye, self._camera, self._events, self._flight):
            part.flush(stream)
        self._note(self._sampled, self._outlet.settle())

    def close(self) -> None:
        """Write the rest and close the recording; further calls do nothing."""
        if self._closed:
            return
        whole = False
        try:
            self._announce("take pictures of the head camera", self._camera.patience)
            self._camera.finish()
            self._announce("take what control still does", _CONTROL_ENDS)
            self._flight.finish(_CONTROL_ENDS, self._outlet.stream)
            self._announce("write the rest", FLUSH_TIMEOUT)
            self.flush()
        finally:
            self._closed = True
            whole = self._outlet.close()
        self._note(self._sampled, whole)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _note(self, until: float, got: bool) -> None:
        """Note up to when [s] the file has everything, if it got what was sent."""
        if got and not self._outlet.trouble:
            self.written = until
        self.written = min(self.written, self._outlet.kept)

    def _layout(self) -> Any:
        return blueprint(self._plots.groups, self._scene.base_height)

    def _check_open(self) -> None:
        if self._closed:
            raise HumanoidBtError("the recording is closed")
