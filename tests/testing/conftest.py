"""Stages that load the robot once for all tests of a process."""

from __future__ import annotations

import pytest

from humanoid_bt import Stage, TreeRun


@pytest.fixture(scope="session")
def stage() -> Stage:
    return Stage()


@pytest.fixture(scope="session")
def dry() -> Stage:
    return Stage(dry=True)


@pytest.fixture(scope="session")
def recorded(dry: Stage, tmp_path_factory: pytest.TempPathFactory) -> TreeRun:
    """Return a staged run with its recording."""
    file = tmp_path_factory.mktemp("staged") / "staged.rrd"
    script = [{"at": 0.1, "lose": "target"}, {"at": 9, "estop": "too late"}]
    return dry.run("fetch", record=file, script=script, replace={"idle": "running"})
