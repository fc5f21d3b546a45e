"""Two short runs that differ in a parameter, recorded once for all tests of what recordings give."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.review.recording import Recording, open_recording
from humanoid_bt.session.run import run
from tests.review.direct import recorded_directly


def short_run(file: Path, **changes: object) -> Path:
    """Record the demo until it has lost sight of the ball."""
    with recorded_directly():
        run("fetch", **{"duration": 3.3, "record": file, "camera": False, **changes})  # type: ignore[arg-type]
    return file


@pytest.fixture(scope="session")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short_run(tmp_path_factory.mktemp("recorded") / "first.rrd")


@pytest.fixture(scope="session")
def other(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short_run(tmp_path_factory.mktemp("recorded") / "other.rrd", parameters={"stop_distance": "35 cm"})


@pytest.fixture(scope="session")
def again(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short_run(tmp_path_factory.mktemp("recorded") / "again.rrd")


@pytest.fixture
def recording(file: Path) -> Recording:
    return open_recording(file)
