from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from tests.projects import make_project
from tests.realtime.helpers import Live

WATCHED = """
format: 1
scene: ball_on_stand
root:
  emergency_stop:
    watchdog:
      percept: target
      max_age: 0.5
      on_stale: {pause: {name: blind, duration: 60}}
      approach: {target: target}
"""


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's project folder."""
    project = make_project(tmp_path_factory.mktemp("user") / "project")
    (project / "trees" / "watched.yaml").write_text(WATCHED, encoding="utf-8")
    return project


@pytest.fixture
def live(project: Path, tmp_path: Path) -> Iterator[Callable[..., Live]]:
    """Start a run as a process of its own; nothing of it outlives the test."""
    started: list[Live] = []

    def start(tree: str, *options: str, wait: bool = True, record: bool = True) -> Live:
        run = Live(project, tmp_path / f"{len(started)}", tree, *options, record=record)
        started.append(run)
        if wait:
            run.ready()
        return run

    yield start
    for run in started:
        run.destroy()
