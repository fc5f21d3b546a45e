"""Two short runs that differ in a parameter, recorded once for all tests of what recordings give."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

import pytest

from humanoid_bt.review.recording import Recording, open_recording
from humanoid_bt.session.run import run
from tests.review.direct import recorded_directly


def short_run(file: Path, **changes: object) -> Path:
    """Record the demo until it has lost sight of the ball."""
    with recorded_directly():
        run("fetch", **{"duration": 2.3, "record": file, "camera": False, **changes})  # type: ignore[arg-type]  # of each their own kind
    return file


def recorded_once(factory: pytest.TempPathFactory, name: str, **changes: object) -> Path:
    """Record a short run in the first process of the tests that asks for it."""
    folder = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent  # which all processes of this run of the tests share
    folder = folder / "recorded"
    folder.mkdir(exist_ok=True)
    file = folder / f"{name}.rrd"
    with (folder / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not file.exists():
            short_run(folder / f"{name}-new.rrd", **changes).rename(file)
    return file


@pytest.fixture(scope="session")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded_once(tmp_path_factory, "first")


@pytest.fixture(scope="session")
def other(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded_once(tmp_path_factory, "other", parameters={"stop_distance": "35 cm"})


@pytest.fixture(scope="session")
def again(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return recorded_once(tmp_path_factory, "again")


@pytest.fixture
def recording(file: Path) -> Recording:
    return open_recording(file)
