"""A robot in a scene, loaded once, on which trees are run one after the other, in lockstep."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import Any, cast, get_args

from py_trees.common import Status

from humanoid_bt.checking.check import load_checked
from humanoid_bt.core.errors import UserError, nearest
from humanoid_bt.core.params import own
from humanoid_bt.core.sources import Sources
from humanoid_bt.decision.result import results_of
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.perception.choice import written
from humanoid_bt.plant.mujoco_plant import MujocoPlant
from humanoid_bt.plant.sensor_failures import sensors_of
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.robot.config import Walk
from humanoid_bt.session import limits
from humanoid_bt.session.drive import Drive
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.listener import Listener
from humanoid_bt.session.options import OnEStop, RunOptions
from humanoid_bt.testing.conditions import Conditions
from humanoid_bt.testing.engines import Engines, Ready
from humanoid_bt.testing.events import Event, mistakes, script_of
from humanoid_bt.testing.fault import Known
from humanoid_bt.testing.staged import Staged
from humanoid_bt.testing.staging import Staging
from humanoid_bt.testing.substitution import Replacement, substituted
from humanoid_bt.testing.tree_run import Sample, TreeRun, View, Watcher
from humanoid_bt.tree.draft import Draft
from humanoid_bt.tree.source.build import remade
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree

_TREES = 100  # loaded trees that are kept, each with the values of its parameters


class Stage:
    """A robot in a scene, loaded once, on which trees are run one after the other, in lockstep.

    Without script, conditions and replacements a run is, bit for bit, what ``humanoid-bt run`` does. A tree's file is
    read once: edits of it and of skills count from the next stage on.

    Args:
        workspace: where names are looked up; the working directory if None.
        robot, scene: names or paths; what each tree says if None.
        dry: without physics: the robot is at once where it is told to be. For the logic of trees only.
        perception: the percept sources, as in a scene file; what each tree or its scene says if None.
        body: what walks and balances, "dcm", "policy" or "own"; what ``robot.yaml`` says if None.

    Raises:
        UserError: the workspace is no folder, or the perception names no sources.
    """

    def __init__(
        self,
        workspace: str | PathLike[str] | Workspace | None = None,
        robot: str | PathLike[str] | None = None,
        scene: str | PathLike[str] | None = None,
        dry: bool = False,
        *,
        perception: str | Mapping[str, Any] | Sequence[Any] | Sources | None = None,
        body: Walk | None = None,
    ) -> None:
        self.workspace = workspace if isinstance(workspace, Workspace) else Workspace(workspace)
        self.dry = dry
        self._robot = None if robot is None else str(robot)
        self._scene = None if scene is None else str(scene)
        self._perception = written(perception)
        self._engines = Engines(self.workspace, self._robot, self._scene, dry, perception=self._perception, body=body)
        self._trees: OrderedDict[tuple[str, str], Tree] = OrderedDict()
        self._stood_in: tuple[Tree, Mapping[str, Replacement], Draft] | None = None

    def run(
        self,
        tree: str | PathLike[str] | Tree,
        *,
        seed: int = 0,
        parameters: Mapping[str, Any] | None = None,
        duration: float | str | None = None,
        on_estop: OnEStop | None = None,
        script: Iterable[Event | Mapping[str, Any]] = (),
        conditions: Conditions | Mapping[str, Any] | None = None,
        replace: Mapping[str, Replacement | Any] | None = None,
        record: str | PathLike[str] | None = None,
        watchers: Iterable[Watcher] | Watcher = (),
    ) -> TreeRun:
        """Run a tree to its end, and let the robot come to a stand.

        Args:
            tree: its name or file, or one that was loaded.
            seed: of everything random.
            parameters: values for the tree's parameters: 0.45, or text as after ``--set``, "45 cm".
            duration: longest simulated time [s], or text, "2 min"; as in ``humanoid-bt run`` if None.
            on_estop: what an emergency stop does to the run: "wait" for its reset, or "end"; if None it waits where
                the script resets it.
            script: faults, each at a time or at a moment; as events, or as in YAML.
            conditions: what is different from the beginning.
            replace: what stands in a node's place, by the node's path, the end of it, or by type.
            record: file of the recording; none is made if None.
            watchers: who looks on, or the only one who does.

        Raises:
            UserError: an argument, the tree, robot, scene or a skill has mistakes, or the recording cannot be opened.
            NodeError: a skill raised an exception in ``setup``.
            KeyboardInterrupt: Ctrl-C; the robot was brought to a stand first.
        """
        seed = int(limits.SEED.take(seed, "seed"))
        if on_estop not in (None, *get_args(OnEStop)):
            raise UserError(f"'on_estop' cannot be {on_estop!r}", hint=nearest(str(on_estop), get_args(OnEStop)))
        for name, value in {"parameters": parameters, "replace": replace}.items():
            if not isinstance(value, (Mapping, type(None))):
                raise UserError(f"{name!r} must be a mapping of names to values, not {value!r}", code="wrong-type")
        looking = tuple(watchers) if isinstance(watchers, Iterable) else (watchers,)
        for watcher in looking:
            if lacking := [name for name in ("tick", "end") if not callable(getattr(watcher, name, None))]:
                hint = "a watcher is an object with tick(view), called after every tick, and end(run)"
                raise UserError(f"the watcher {watcher!r} has no {' and no '.join(lacking)}", hint=hint)
        staging = Staging(
            self.dry,
            Conditions.of(conditions),
            {name: Replacement.of(value, name) for name, value in (replace or {}).items()},
            script_of(script),
        )
        loaded = self._loaded(tree, parameters or {})
        initials = [(key, key.initial) for key in loaded.keys]
        try:
            ready = self._engines.ready(loaded, seed, staging.conditions)
            engine = Staged(ready.engine, staging.script, seed, ready.plant)
            staged = self._remade(loaded, staging)
            _check(staging, loaded, staged, ready)
            options = RunOptions(
                tree=staged,
                robot=str(ready.robot),
                scene=str(ready.scene),
                perception=self._perception,
                parameters=parameters or {},
                seed=seed,
                on_estop=on_estop or ("wait" if any(event.reset for event in staging.script) else None),
                duration=None if duration is None else limits.DURATION.take(duration, "duration"),
                sinks=Sinks(file=_recording(record)),
                staged=staging.told(),
            )
            listener = _Changes()
            drive = Drive(options, self.workspace, listener, engine=cast(Engine, engine), looks=not self.dry)
            engine.enter(_known(loaded, drive.runner.tree, staging, ready), drive.runner.robot, staging.lines)
            return _run(drive, engine, listener, looking, staging)
        finally:
            for key, initial in initials:
                key.initial = initial

    @property
    def plant(self) -> MujocoPlant | None:
        """The simulated plant as the last run has left it: the truth of it; None before a run, and without physics."""
        return self._engines.plant

    def _loaded(self, tree: str | PathLike[str] | Tree, parameters: Mapping[str, Any]) -> Tree:
        """Return a tree as its file says, read once."""
        if isinstance(tree, Tree):
            if parameters:
                message = f"the tree {tree.name!r} is loaded already, with its parameters"
                raise UserError(message, hint="give its name, or the parameters where it is loaded")
            return tree
        key = str(tree), repr(sorted(parameters.items()))
        if key not in self._trees:
            path = self.workspace.find_tree(str(tree))
            self._trees[key] = load_checked(
                path,
                self.workspace,
                parameters,
                robot=self._robot,
                scene=self._scene,
                perception=self._perception,
            )
            if len(self._trees) > _TREES:
                self._trees.popitem(last=False)
        self._trees.move_to_end(key)
        return self._trees[key]

    def _remade(self, tree: Tree, staging: Staging) -> Tree:
        """Return a tree with nodes of its own, and stand-ins where they are wanted.

        Raises:
            UserError: nodes cannot be replaced so.
        """
        if tree.draft is None or not tree.complete:
            if staging.replace:
                hint = "write it to a file, with its to_yaml(), and run that"
                raise UserError(f"nodes of {tree.name!r}, which was made in Python, cannot be replaced", hint=hint)
            return tree  # it says itself that it runs once
        if not staging.replace:
            return remade(tree, tree.draft)
        if self._stood_in is None or self._stood_in[0] is not tree or self._stood_in[1] != staging.replace:
            self._stood_in = tree, staging.replace, substituted(tree, tree.draft, staging.replace)
        return remade(tree, self._stood_in[2])


def _recording(record: str | PathLike[str] | None) -> Path | None:
    """Return the file of a recording, None for none; raises UserError if its name is none of a recording."""
    path = None if record is None else Path(record)
    if path is not None and path.suffix != ".rrd":
        raise UserError(
            f"'record' must be a file that ends in .rrd, not {str(path)!r}", hint=f"{path.with_suffix('.rrd')}"
        )
    return path


def _known(loaded: Tree, tree: Tree, staging: Staging, ready: Ready) -> Known:
    robot = ready.engine.robot
    percepts = [*ready.engine.publishes, *(event.see.percept for event in staging.script if event.see is not None)]
    asked = {*ready.engine.publishes, *loaded.percepts}
    sensors = sensors_of(robot.config.sensors, robot.joint_names)
    return Known(tree, robot.config.torso, robot.joint_names, sensors, ready.bodies, percepts, asked, staging.dry)


def _check(staging: Staging, loaded: Tree, tree: Tree, ready: Ready) -> None:
    """Look up the names in a script.

    Args:
        staging: what the test does.
        loaded: the tree as its file says.
        tree: the same with stand-ins.
        ready: what it runs on.

    Raises:
        UserError: with everything that a script asks for and is not there.
    """
    if problems := list(mistakes(staging.script, _known(loaded, tree, staging, ready))):
        raise UserError(problems)


def _run(drive: Drive, engine: Staged, listener: _Changes, watchers: Sequence[Watcher], staging: Staging) -> TreeRun:
    """Run a tree to its end, and return what there was to see."""
    tree, config = drive.runner.tree, engine.robot.config
    view, samples = View(tree, drive.runner.robot), list[Sample]()
    drive.start()
    try:
        while drive.running:
            drive.tick()
            if (sample := _sample(drive, engine, listener)) is not None:
                samples.append(sample)
                view.move_on(sample)
                engine.look(view)
                for watcher in watchers:
                    watcher.tick(view)
        missed = engine.close_script()
    except BaseException as error:  # a mistake of a watcher too: the robot stands and the recording is whole first
        drive.leave("interrupted", "Ctrl-C" if isinstance(error, KeyboardInterrupt) else str(error))
        raise
    finally:
        drive.close()
    assert drive.report is not None
    report = replace(drive.report, staged=staging.told([one.event for one in missed]))
    run = TreeRun(report, tree, samples, listener.all, list(engine.supervisor.stops), config, missed)
    for watcher in watchers:
        watcher.end(run)
    return run


def _sample(drive: Drive, engine: Staged, listener: _Changes) -> Sample | None:
    """Return what is kept of the last tick, None if there was none."""
    state, command, changes = drive.loop.state, drive.loop.command, listener.take()
    if state is None:
        return None
    results = {change.path: {name: value for name, value, _ in change.results} for change in changes if change.results}
    for path, skill in drive.runner.reporting:
        if skill.status is Status.RUNNING:
            results[path] = dict(results_of(skill))
    keys = {key.name: own(key.value) for key in drive.runner.tree.keys if key.is_set}
    touched = tuple(dict.fromkeys(touch.thing for touch in engine.touches))
    bumped = tuple(dict.fromkeys(touch.thing for touch in engine.touches if not touch.meant))
    given = command if command.stamp == state.time else None
    return Sample(state, engine.percepts, given, changes, keys, results, drive.truth, touched, bumped)


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
