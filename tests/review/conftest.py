from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.session.session import Session
from tests.review.direct import recorded_directly
from tests.review.staging import make_stage

Play = Callable[..., Path]


@pytest.fixture(scope="session")
def stage(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace with a tree for each way to stop a robot."""
    return make_stage(tmp_path_factory.mktemp("stage") / "stage")


@pytest.fixture(scope="session")
def play(stage: Path, tmp_path_factory: pytest.TempPathFactory) -> Play:
    """Run a tree of the stage, with something done to it at a time; return its recording."""
    folder = tmp_path_factory.mktemp("runs")

    def run(
        tree: str, duration: float = 1.0, at: float = 0.0, do: Callable[[Session], Any] | None = None, **options: Any
    ) -> Path:
        file = folder / f"{tree}-{len(list(folder.iterdir()))}.rrd"
        with (
            contextlib.chdir(stage),
            recorded_directly(),
            Session(tree, workspace=stage, record=file, camera=False, duration=duration, **options) as session,
        ):
            if do is not None:
                session.run_until(at)
                do(session)
            while not session.outcome:
                session.step()
        return file

    return run
