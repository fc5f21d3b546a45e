"""A robot in a scene, loaded once, on which trees are run one after the other, in lockstep."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any, cast

from py_trees.common import Status

from humanoid_bt.checking.check import load_checked
from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.decision.result import results_of
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.simulated import SimulatedPerception
from humanoid_bt.plant.scene import Scene, SceneConfig, load_scene
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.session.drive import Drive
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.loader import DEFAULT_ROBOT, DEFAULT_SCENE
from humanoid_bt.session.lockstep import Lockstep
from humanoid_bt.session.options import RunOptions
from humanoid_bt.session.teller import Listener
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.events import Event, script_of
from humanoid_bt.testing.staged import Staged
from humanoid_bt.testing.substitution import Replacement
from humanoid_bt.testing.tree_run import Sample, TreeRun, View, Watcher
from humanoid_bt.tree.source.build import remade
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree


class Stage:
    """A robot in a scene, loaded once, on which trees are run one after the other, in lockstep.

    Without script, conditions and replacements a run is, bit for bit, what ``humanoid-bt run`` does. A tree's file is
    read once: edits of it and of skills count from the next stage on.

    Args:
        workspace: where names are looked up; the working directory if None.
        robot, scene: names or paths; what each tree says if None.
        dry: without physics: the robot is at once where it is told to be. For the logic of trees only.

    Raises:
        UserError: the workspace is no folder.
    """

    def __init__(
        self,
        workspace: str | PathLike[str] | Workspace | None = None,
        robot: str | PathLike[str] | None = None,
        scene: str | PathLike[str] | None = None,
        dry: bool = False,
    ) -> None:
        self.workspace = workspace if isinstance(workspace, Workspace) else Workspace(workspace)
        self.dry = dry
        self._robot = None if robot is None else str(robot)
        self._scene = None if scene is None else str(scene)
        self._trees: dict[Any, Tree] = {}
        self._scenes: dict[Path, SceneConfig] = {}
        self._engines: dict[Any, Lockstep] = {}

    def run(
        self,
        tree: str | PathLike[str] | Tree,
        *,
        seed: int = 0,
        parameters: Mapping[str, Any] | None = None,
        duration: float | None = None,
        script: Iterable[Event | Mapping[str, Any]] = (),
        conditions: Conditions | Mapping[str, Any] | None = None,
        replace: Mapping[str, Replacement | Any] | None = None,
        record: str | PathLike[str] | None = None,
        watchers: Sequence[Watcher] = (),
    ) -> TreeRun:
        """Run a tree to its end, and let the robot come to a stand.

        Args:
            tree: its name or file, or one that was loaded.
            seed: of everything random.
            parameters: values for the tree's parameters: 0.45, or text as after ``--set``, "45 cm".
            duration: longest simulated time [s]; as in ``humanoid-bt run`` if None.
            script: faults, each at a time or at a moment; as events, or as in YAML.
            conditions: what is different from the beginning.
            replace: what stands in a node's place, by the node's path, the end of it, or by type.
            record: file of the recording; none is made if None.
            watchers: who looks on.

        Raises:
            UserError: an argument, the tree, robot, scene or a skill has mistakes, or the recording cannot be opened.
            NodeError: a skill raised an exception in ``setup``.
        """
        script_of(script)
        loaded = self._tree(tree, parameters or {})
        options = RunOptions(
            tree=loaded,
            robot=self._robot,
            scene=self._scene,
            parameters=parameters or {},
            seed=seed,
            duration=duration,
            sinks=Sinks(file=None if record is None else Path(record)),
        )
        engine = Staged(self._engine(loaded, seed, Conditions.of(conditions)))
        listener = _Changes()
        drive = Drive(options, self.workspace, listener, engine=cast(Engine, engine))
        view = View(loaded, drive.runner.robot)
        samples: list[Sample] = []
        drive.start()
        try:
            while drive.running:
                drive.tick()
                if (sample := self._sample(drive, engine, listener)) is None:
                    continue
                samples.append(sample)
                view.move_on(sample)
                for watcher in watchers:
                    watcher.tick(view)
        except KeyboardInterrupt:
            drive.leave("interrupted", "Ctrl-C")
            raise
        finally:
            drive.close()
        assert drive.report is not None
        stops = list(engine.supervisor.stops)
        run = TreeRun(drive.report, loaded, samples, listener.all, stops, engine.robot.config)
        for watcher in watchers:
            watcher.end(run)
        return run

    def _sample(self, drive: Drive, engine: Staged, listener: _Changes) -> Sample | None:
        state = drive.loop.state
        if state is None:
            return None
        command = drive.loop.command if drive.loop.command.stamp == state.time else None
        changes = listener.take()
        keys = {key.name: key.value for key in drive.runner.tree.keys if key.is_set}
        results = {change.path: {name: value for name, value, _ in change.results} for change in changes}
        for path, skill in drive.runner.reporting:
            if skill.status is Status.RUNNING:
                results[path] = dict(results_of(skill))
        return Sample(state, engine.percepts, command, changes, keys, results)

    # ---- what is loaded once ----------------------------------------------------------------------------------------

    def _tree(self, tree: str | PathLike[str] | Tree, parameters: Mapping[str, Any]) -> Tree:
        """Return a tree with nodes of its own."""
        if isinstance(tree, Tree):
            if tree.draft is None:
                return tree  # made in Python: it runs once
            return remade(tree, tree.draft)
        key = (str(tree), repr(sorted(parameters.items())))
        if key not in self._trees:
            path = self.workspace.find_tree(str(tree))
            self._trees[key] = load_checked(path, self.workspace, parameters, robot=self._robot, scene=self._scene)
        known = self._trees[key]
        assert known.draft is not None
        return remade(known, known.draft)

    def _engine(self, tree: Tree, seed: int, conditions: Conditions) -> Lockstep:
        """Return the engine for a run of a tree, reset."""
        robot_file = self.workspace.find_robot(self._robot or tree.robot or DEFAULT_ROBOT)
        scene_file = self.workspace.find_scene(self._scene or tree.scene or DEFAULT_SCENE)
        if scene_file not in self._scenes:
            self._scenes[scene_file] = load_scene(scene_file)
        config = conditions.seen(self._scenes[scene_file])
        scene = Scene(config, seed)
        perception = SimulatedPerception(scene, seed)
        by_chance = any(thing.random is not None for thing in config.objects.values())
        key = robot_file, scene_file, seed if by_chance else None
        engine = self._engines.get(key)
        if engine is None:
            self._engines.clear()
            robot, start = load_robot(robot_file)
            engine = self._engines[key] = Lockstep(robot, start, scene, perception)
        engine.plant.alter(**conditions.of_body)
        engine.reset(perception, scene)
        return engine


class _Changes(Listener):
    """Keeps the nodes' changes of status."""

    def __init__(self) -> None:
        self.all: list[NodeChange] = []
        self._taken = 0

    def node_changed(self, change: NodeChange) -> None:
        """Keep one."""
        self.all.append(change)

    def take(self) -> tuple[NodeChange, ...]:
        """Return those since the last time."""
        since, self._taken = self._taken, len(self.all)
        return tuple(self.all[since:])
