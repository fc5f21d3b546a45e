"""Running a tree of a project as the command line does, with everything it tells kept."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import rerun as rr

from humanoid_bt.session.listener import Listener
from humanoid_bt.session.report import Report
from humanoid_bt.session.session import Session
from humanoid_bt.tree.ticking.executor import NodeChange
from humanoid_bt.tree.tree import Tree


@dataclass
class Told(Listener):
    """A listener that keeps what it is told."""

    changes: list[NodeChange] = field(default_factory=list)
    events: list[tuple[float, str, str]] = field(default_factory=list)
    shown: list[Tree] = field(default_factory=list)
    ticks: int = 0

    def node_changed(self, change: NodeChange) -> None:
        self.changes.append(change)

    def event(self, time: float, level: str, text: str) -> None:
        self.events.append((time, level, text))

    def progress(self, time: float, running: str) -> None:
        self.ticks += 1

    def show(self, tree: Tree) -> None:
        self.shown.append(tree)


@dataclass
class Ran:
    """A run that is over."""

    session: Session
    report: Report
    told: Told
    recording: Path | None

    @property
    def settled(self) -> bool:
        """Whether the robot came to a stand."""
        return self.session.engine.sense()[0].base_settled


def ran(
    tree: str,
    project: Path,
    recording: Path | None = None,
    interrupted: Callable[[], str] = lambda: "",
    *,
    seed: int = 0,
    duration: float | None = 30.0,
    on_estop: Literal["wait", "end"] | None = None,
    scene: str | None = None,
) -> Ran:
    """Run a tree to its end."""
    told = Told()
    record = recording or False
    session = Session(
        tree,
        workspace=project,
        seed=seed,
        duration=duration,
        on_estop=on_estop,
        scene=scene,
        record=record,
        camera=False,
        listener=told,
    )
    return Ran(session, play(session, interrupted), told, recording)


def play(session: Session, interrupted: Callable[[], str] = lambda: "") -> Report:
    """Run a session to its end, or until the answer that is asked for after every tick is a reason to end."""
    with suppress(KeyboardInterrupt), session:
        while session.step():
            if reason := interrupted():
                session.interrupt(reason)
    return session.report


def after(calls: int, reason: str) -> Callable[[], str]:
    """Return an interruption that comes at a tick, counted from 1."""
    count = 0

    def ask() -> str:
        nonlocal count
        count += 1
        return reason if count >= calls else ""

    return ask


_VERIFY = [str(Path(sys.executable).parent / "rerun"), "rrd", "verify"]


def last_time(recording: Path) -> float:
    """Return the last time [s] in a recording."""
    assert subprocess.run([*_VERIFY, str(recording)], check=False, capture_output=True).returncode == 0
    times = [0.0]
    for chunk in rr.chunk.RrdReader(recording).stream():
        batch = chunk.to_record_batch()
        if "sim_time" in batch.schema.names:
            times += [time.total_seconds() for time in batch.column("sim_time").to_pylist()]
    return max(times)
