"""Opening the recording of a run, and finding out whether it was written."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from humanoid_bt.core.errors import UserError, relative
from humanoid_bt.core.messages import Level
from humanoid_bt.plant.scene_config import widest_view
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.session.engine import Engine
from humanoid_bt.session.options import RunOptions
from humanoid_bt.session.report import versions
from humanoid_bt.tree.show import outline_of
from humanoid_bt.tree.tree import Tree

if TYPE_CHECKING:  # most runs of a program record nothing, and the viewer's library takes half a second
    from humanoid_bt.record.recorder import Recorder
    from humanoid_bt.record.tree_view import TreeView

_BUSY_CORES = {"lockstep": 1, "realtime": 2}  # in realtime mode one is control's, and decision must not wait either
_FULL_DISK = 64 * 1024  # bytes; what cannot be written of a recording is smaller than this


def open_recorder(
    options: RunOptions, tree: Tree, engine: Engine, tell: Callable[[float, Level, str], None]
) -> tuple[Recorder, bool]:
    """Return the recorder of a run, and whether anybody can watch it live.

    Args:
        options: where it goes, and whether the native viewer may be missing.
        tree: what runs.
        engine: what it runs on.
        tell: is told time, level and text of where to watch, or why there is no live view.

    Raises:
        UserError: a sink cannot be opened.
    """
    sinks = options.sinks
    try:
        recorder = _recorder(sinks, tree, engine, options)
    except UserError as error:
        if not (sinks.view and options.view_optional):
            raise
        tell(0.0, "warning", f"no live view: {error.problems[0].message}")
        sinks = dataclasses.replace(sinks, view=False)
        recorder = _recorder(sinks, tree, engine, options)
    if recorder.url:
        tell(0.0, "info", f"live view: {recorder.url}")
    return recorder, sinks.view or sinks.serve is not None


def tree_view(tree: Tree) -> TreeView:
    """Return what a recording shows of a tree."""
    from humanoid_bt.record.tree_view import TreeView  # noqa: PLC0415 (see above)

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


def cut_short(recording: Path | None) -> str:
    """Return what is wrong with a closed recording, "" if nothing is (the viewer's library only logs it)."""
    if recording is None:
        return ""
    if not recording.exists():
        return f"the recording {str(recording)!r} is lost: it was removed during the run"
    if shutil.disk_usage(recording.parent).free >= _FULL_DISK:
        return ""
    return f"the disk is full: the recording {str(recording)!r} is cut short"


def _recorder(sinks: Sinks, tree: Tree, engine: Engine, options: RunOptions) -> Recorder:
    from humanoid_bt.record.camera import View  # noqa: PLC0415 (see above)
    from humanoid_bt.record.recorder import Recorder  # noqa: PLC0415 (see above)

    robot = engine.robot
    view, info = tree_view(tree), run_info(tree, engine)
    return Recorder(
        engine.model,
        robot.joint_names,
        robot.config,
        tree=view,
        sinks=sinks,
        info=info,
        camera=View(robot.config.gaze.body, *widest_view(engine.scene.config)),
        pictures=options.camera,
        busy_cores=_BUSY_CORES[options.mode],
    )
