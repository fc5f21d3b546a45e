"""Opening the recording of a run."""

from __future__ import annotations

import dataclasses
import itertools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.messages import Array, Level
from humanoid_bt.decision.result import Reported
from humanoid_bt.perception.track import Track
from humanoid_bt.plant.rendering import View
from humanoid_bt.plant.scene_config import widest_view
from humanoid_bt.realtime.schedule import last_core
from humanoid_bt.record.remote_recorder import RemoteRecorder
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.record.subject import TreeView
from humanoid_bt.record.tick import Tick
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.options import RunOptions
from humanoid_bt.session.report import versions
from humanoid_bt.tree.show import outline_of
from humanoid_bt.tree.tree import Tree

_BUSY_CORES = 1  # decision's; control's, in realtime mode, is none of the recorder's


class RunRecorder(Protocol):
    """What takes everything that is recorded of a run, as :class:`RemoteRecorder` does; entered for the run.

    Attributes:
        url: address of the web viewer, "" if none is served.
    """

    url: str

    @property
    def missing(self) -> float:
        """How much of the run is missing in the recording [s]."""

    def open(self, **setup: Any) -> None:
        """Begin with what is run."""

    def follow(self, plans: Path, cycles: Path) -> None:
        """Take the servo cycles that control keeps in these tables."""

    def cycles(self, plans: Array, cycles: Array) -> None:
        """Take servo cycles."""

    def routes(self, time: float, routes: Sequence[Sequence[Sequence[float]]]) -> None:
        """Record the ways that are followed from a time on, points x, y of each, world frame [m]."""

    def truth(self, time: float, pose: Sequence[float]) -> None:
        """Record where the base really is."""

    def sample(
        self, tick: Tick, tracks: Mapping[str, Track], objects: Mapping[str, Array], hidden: Iterable[str] = ()
    ) -> None:
        """Take a tick."""

    def node_changed(self, time: float, path: str, status: str, feedback: str) -> None:
        """Take a node's change of status."""

    def results(self, time: float, path: str, results: Sequence[Reported]) -> None:
        """Take what a skill has reported by now."""

    def show_tree(self, time: float, tree: TreeView, info: Mapping[str, str]) -> None:
        """Take another tree in the tree's place."""

    def event(self, time: float, level: Level, text: str) -> None:
        """Take something that happened."""

    def news(self, time: float, kind: str, value: Any) -> None:
        """Take something that is kept without being shown."""

    def take_news(self) -> list[tuple[Level, str]]:
        """Return what went wrong since the last time."""

    def __enter__(self) -> Self:
        """Begin."""

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close."""


def new_recorder(options: RunOptions) -> RemoteRecorder | None:
    """Return the recorder of a run, which comes up while the rest is made ready; None if nothing is recorded."""
    if not options.sinks.active:
        return None
    if options.mode == "realtime":
        return RemoteRecorder(waits=False, core=last_core())
    return RemoteRecorder(waits=True)


def open_recorder(
    recorder: RunRecorder,
    options: RunOptions,
    tree: Tree,
    engine: Engine,
    *,
    setup: Mapping[str, Any],
    tell: Callable[[float, Level, str], None],
) -> Sinks:
    """Open the recording of a run; return where it goes after all.

    Args:
        recorder: of the run.
        options: where it is to go, and whether the native viewer may be missing.
        tree: what runs.
        engine: what it runs on.
        setup: what is kept of what runs.
        tell: is told time, level and text of where to watch, or why there is no live view.

    Raises:
        UserError: a sink cannot be opened.
        HumanoidBtError: the recorder does not come up.
    """
    sinks, reserved = options.sinks, None
    if sinks.file is not None and options.numbered:
        reserved = reserve(sinks.file)
        sinks = dataclasses.replace(sinks, file=reserved)
    try:
        try:
            _open(recorder, sinks, tree, engine, options, setup=setup)
        except UserError as error:
            if not (sinks.view and options.view_optional):
                raise
            tell(0.0, "warning", f"no live view: {error.problems[0].message}")
            sinks = dataclasses.replace(sinks, view=False)
            _open(recorder, sinks, tree, engine, options, setup=setup)
    except BaseException:
        if reserved is not None:
            reserved.unlink(missing_ok=True)
        raise
    if recorder.url:
        tell(0.0, "info", f"live view: {recorder.url}")
    return sinks


def reserve(path: Path) -> Path:
    """Make an empty file of this name, or if it is taken of the next one with a number; return it.

    Raises:
        UserError: it cannot be made.
    """
    for number in itertools.count(1):
        free = path if number == 1 else path.with_stem(f"{path.stem}-{number}")
        try:
            os.close(os.open(free, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666))
        except FileExistsError:
            continue
        except OSError as error:
            raise UserError(f"the recording {relative(free)!r} cannot be written: {error.strerror}") from error
        break
    return free


def tree_view(tree: Tree) -> TreeView:
    """Return what a recording shows of a tree."""
    return TreeView(outline_of(tree), tree.source, relative(tree.path))


def run_info(tree: Tree, engine: Engine) -> dict[str, str]:
    """Return what a recording says about a run of a tree: heading -> text."""
    return {
        "tree": tree.name,
        "robot": engine.robot.config.name,
        "scene": engine.scene.config.name,
        "seed": str(engine.scene.seed),
        "parameters": ", ".join(f"{name} = {value}" for name, value in tree.parameters.items()),
        "versions": ", ".join(f"{name} {version}" for name, version in versions().items()),
    }


def _open(
    recorder: RunRecorder,
    sinks: Sinks,
    tree: Tree,
    engine: Engine,
    options: RunOptions,
    *,
    setup: Mapping[str, Any],
) -> None:
    robot = engine.robot
    recorder.open(
        model=engine.model,
        joint_names=robot.joint_names,
        config=robot.config,
        tree=tree_view(tree),
        sinks=dataclasses.replace(sinks, file=sinks.file and sinks.file.absolute()),
        info=run_info(tree, engine) | ({"staged": "\n".join(options.staged["told"])} if options.staged else {}),
        setup=setup,
        camera=View(robot.config.gaze.body, *widest_view(engine.scene.config)),
        pictures=options.camera,
        busy_cores=_BUSY_CORES,
    )
