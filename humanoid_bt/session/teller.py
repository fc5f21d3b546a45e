"""Telling what happens in a run: to the listener, to the recording, to the trace, to who looks from outside."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from typing import Any

from humanoid_bt.core.errors import nearest
from humanoid_bt.core.messages import Command, Level, Percept, State, Truth
from humanoid_bt.core.odometry import odometry_error
from humanoid_bt.core.plain import plain
from humanoid_bt.core.texts import shortened
from humanoid_bt.decision.result import reported
from humanoid_bt.record.tick import Tick
from humanoid_bt.session.changes import Changes
from humanoid_bt.session.engine import Engine, Input
from humanoid_bt.session.happenings import Happenings
from humanoid_bt.session.listener import Guarded
from humanoid_bt.session.outcome import End
from humanoid_bt.session.recording import RunRecorder, run_info, tree_view
from humanoid_bt.session.setup import tree_setup
from humanoid_bt.session.trace import Trace
from humanoid_bt.session.tree_runner import TreeRunner
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.ticking.tick import RUNNING
from humanoid_bt.tree.tree import Tree

NO_PERCEPT = "publishes no percept"
"""What the warning about a percept that can never come says."""

_STATUS_PERIOD = 0.2  # s on the wall clock between two reports to whoever looks from outside
_MOST_TOLD = 1000  # characters of a text in them


class Teller:
    """Passes on what happens, to everybody in the same order.

    Args:
        listener: who is told.
        engine: what runs below the tree.
        given: the parameters that were given from outside.

    Attributes:
        trace: what is kept for the report.
        recorder: the recording, if there is one; set to None it is told no more.
        waits: whether an emergency stop is waited for, until its reset.
        resting: what the run does between two trees, in words.
        truth: where the robot really was at the last tick, None if nobody knows.
    """

    def __init__(self, listener: Guarded, engine: Engine, given: Mapping[str, Any]) -> None:
        self._listener, self._engine, self._given = listener, engine, given
        self._happenings, self._changes = Happenings(engine), Changes(engine)
        self.trace = Trace()
        self.recorder: RunRecorder | None = None
        self.waits = False
        self.resting = "waiting for an edit"
        self.truth: Truth | None = None
        self._state: State | None = None  # of the last tick
        self._began = time.monotonic()
        self._ticks = 0
        self._published = -math.inf  # on the monotonic clock [s]
        self._routes: list[list[list[float]]] = []  # that were recorded last

    @property
    def now(self) -> float:
        """The engine's time [s]."""
        return self._engine.clock.now()

    @property
    def odometry(self) -> dict[str, float] | None:
        """How far the robot was from where it was believed to be: off [m], turned [rad]; None if nobody knows."""
        if self.truth is None or self._state is None:
            return None
        return dict(zip(("off", "turned"), odometry_error(self._state, self.truth), strict=True))

    def begin(self) -> None:
        """Count ticks from now on, and tell what there is to say before the first one."""
        self._began = time.monotonic()
        for notice in self._happenings.notices():
            self.event(notice.level, notice.text, notice.time)

    def event(self, level: Level, text: str, at: float | None = None) -> None:
        """Tell of something that happened, now or at an engine time [s]."""
        now, text = self.now if at is None else at, shortened(text)
        self.trace.events.append((now, level, text))
        self._listener.event(now, level, text)
        self._engine.announce("event", {"time": now, "level": level, "text": text})
        if self.recorder is not None:
            self.recorder.event(now, level, text)

    def given(self, kind: str, value: Any) -> None:
        """Keep for a replay what was done to the tree from outside, now: kind and value of an :class:`Input`."""
        self._engine.inputs.append(Input(self.now, kind, value))

    def tree_ended(self, outcome: str, more: str = "") -> None:
        """Tell that the tree ended."""
        self.event("info" if outcome == "success" else "warning", f"the tree ended: {outcome}{more}")

    def node_tells(self, source: str, level: Level, text: str) -> None:
        """Tell what a node has to say.

        Args:
            source: the node's path.
            level: info, warning or error.
            text: what it says.
        """
        self.event(level, f"{text}  ({source})")

    def node_changed(self, change: NodeChange) -> None:
        """Tell that a node's status changed."""
        self.trace.node_changed(change)
        self._listener.node_changed(change)
        now = {"path": change.path, "status": change.status.name, "feedback": shortened(change.feedback)}
        self._engine.announce("node", {"time": change.time, **now})
        if self.recorder is not None:
            said = "; ".join(filter(None, [change.feedback, *map(str, change.results)]))
            self.recorder.node_changed(change.time, change.path, change.status.name, said)
            self.recorder.results(change.time, change.path, change.results)

    def happened(self, state: State) -> None:
        """Tell what happened besides the tree up to now."""
        happenings = self._happenings
        for happening in (*happenings.until(state.time, self.waits), *happenings.touches(state)):
            self.event(happening.level, happening.text, happening.time)

    def news(self, recorder: RunRecorder) -> None:
        """Tell what went wrong with the recording."""
        for level, text in recorder.take_news():
            self.event(level, text)

    def show(self, tree: Tree) -> None:
        """Tell that another tree takes the place of the one that ran."""
        self._listener.show(tree)
        if self.recorder is not None:
            self.recorder.show_tree(self.now, tree_view(tree), run_info(tree, self._engine))
            self.recorder.news(self.now, "tree", tree_setup(tree, self._given))
        self.warn_of_percepts(tree)

    def warn_of_percepts(self, tree: Tree) -> None:
        """Say which percepts will never come: a tree may well wait for one, but most often it is a slip."""
        publishes, config = self._engine.publishes, self._engine.scene.config
        named = {name for node in tree.nodes for names in node.type.percepts(node.values).values() for name in names}
        for name in sorted(named - set(publishes)):
            hint = nearest(name, publishes) or "it publishes none"
            whose = f"the scene {config.name!r}" if set(publishes) == set(config.percepts) else "perception"
            self.event("warning", f"{whose} {NO_PERCEPT} {name!r} ({hint})")

    def ticked(
        self,
        runner: TreeRunner,
        state: State,
        percepts: Mapping[str, Percept],
        command: Command | None = None,
        took: float = 0.0,
    ) -> None:
        """Tell what a tick saw and did, or that there was none because the run is paused.

        Args:
            runner: what runs the tree.
            state, percepts: what it saw.
            command: what it commanded, None if a node raised an exception.
            took: how long the tree took, on the wall clock [s].
        """
        robot = runner.robot
        self._state, self.truth = state, self._engine.truth
        if self.recorder is not None:
            scene = self._engine.scene
            objects = {name: scene.object_position(name, state.time) for name in scene.config.objects}
            hidden = {name for name in objects if scene.hidden(name, state.time)}
            if rows := self._engine.take_cycles():
                self.recorder.cycles(*rows)
            for kind, value in self._changes.since(runner.tree):
                self.recorder.news(state.time, kind, value)
            for path, skill in runner.reporting:
                if skill.status is RUNNING:
                    self.recorder.results(state.time, path, reported(skill))
            if (truth := self.truth) is not None:
                self.recorder.truth(truth.time, [*truth.base_position.tolist(), *truth.base_quaternion.tolist()])
            tick = Tick(state, self._changes.percepts(percepts), command, took)
            routes = [route.tolist() for route in robot.routes]
            if routes != self._routes:
                self._routes = routes
                self.recorder.routes(state.time, routes)
            self.recorder.sample(tick, robot.tracks, objects, hidden)
            self.news(self.recorder)
        if self._listener.hears_progress:
            self._listener.progress(state.time, self._doing(runner, command))
        self._ticks += 1
        if time.monotonic() - self._published >= _STATUS_PERIOD:
            self._publish(state, runner)

    def _doing(self, runner: TreeRunner, command: Command | None) -> str:
        """Return what the tree does after a tick in which it commanded this, in words."""
        tip = runner.tip
        resting = self.resting if runner.ended else "coming to a stand"
        doing = ": ".join(filter(None, [tip.name, shortened(tip.feedback_message)])) if tip is not None else resting
        pause = command.pause if command is not None else None
        return doing if pause is None else f"paused at {doing}; by {pause.source}: {pause.reason}"

    def ended(self, end: End, tree_ended: float | None, slow_ticks: Mapping[str, Any]) -> None:
        """Keep how the run ended.

        Args:
            end: how.
            tree_ended: engine time at which the tree ended [s], None if it never was ticked.
            slow_ticks: ticks that took longer than their period.
        """
        if self.recorder is not None:
            said = {name: shortened(text) for name, text in end._asdict().items()}
            self.recorder.news(self.now, "end", {**said, "tree_ended": tree_ended, "slow_ticks": plain(slow_ticks)})

    def _publish(self, state: State, runner: TreeRunner) -> None:
        """Tell ``humanoid-bt status`` and ``show --live`` what goes on."""
        robot, tip, now = runner.robot, runner.tip, time.monotonic()
        self._published = now
        self._engine.publish(
            {
                "time": state.time,
                "told_at": now,
                "node": shortened(getattr(tip, "path", ""), _MOST_TOLD),
                "feedback": shortened(tip.feedback_message, _MOST_TOLD) if tip is not None else "",
                "tick_rate": self._ticks / max(now - self._began, 1e-9),
                "percepts": {name: round(track.age, 3) for name, track in robot.tracks.items()},
                "unseen": dict(self._engine.unseen),
            },
            runner.tree,
        )
