"""What to run, and how."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

from humanoid_bt.core.errors import UserError
from humanoid_bt.record.sinks import Sinks
from humanoid_bt.tree.tree import Tree

Mode = Literal["lockstep", "realtime"]

RUNS = Path("runs")
"""Folder of recordings below the working directory; made when it is needed."""

DURATION = 120.0
"""Longest simulated time of a run that says nothing else [s]."""


@dataclass(frozen=True)
class RunOptions:
    """What to run, and how.

    Attributes:
        tree: name or path of the tree, or a tree that was loaded or made in Python.
        robot, scene: names or paths; None for what the tree says.
        overrides: parameter values as text.
        seed: of everything random.
        duration: longest simulated time [s].
        pace: simulated seconds per second; None for 1 with a live view, else as fast as it can.
        sinks: where the recording goes.
        mode: lockstep, or realtime with control and perception as processes of their own.
        hold: in realtime mode, how long control balances the robot when decision has died [s].
        watch: swap the tree for an edited one whenever its files change; goes on when the tree has ended.
        view_optional: go on without the native viewer if it cannot be opened.
    """

    tree: str | Tree
    robot: str | None = None
    scene: str | None = None
    overrides: Mapping[str, str] = field(default_factory=dict)
    seed: int = 0
    duration: float = DURATION
    pace: float | None = None
    sinks: Sinks = field(default_factory=Sinks)
    mode: Mode = "lockstep"
    hold: float = 10.0
    watch: bool = False
    view_optional: bool = False


def default_recording(tree: str) -> Path:
    """Return where a run is recorded by default: a file in :data:`RUNS` that is not there yet."""
    stamp = time.strftime("%Y%m%d-%H%M%S")
    name = Path(tree).stem
    path = RUNS / f"{name}-{stamp}.rrd"
    number = 2
    while path.exists():
        path = RUNS / f"{name}-{stamp}-{number}.rrd"
        number += 1
    return path


def make_folder(recording: Path) -> None:
    """Make the folder of recordings if this one goes there.

    Raises:
        UserError: the folder cannot be made.
    """
    if recording.parent != RUNS:
        return
    try:
        RUNS.mkdir(exist_ok=True)
    except OSError as error:
        hint = "give another place with --record FILE, or --no-record"
        raise UserError(f"the folder {str(RUNS.absolute())!r} cannot be made: {error.strerror}", hint=hint) from error
