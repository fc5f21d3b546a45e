"""The pytest plugin: the ``rig`` fixture, and scenario files as tests."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from humanoid_bt.testing.plugin_scenarios import pytest_collect_file  # noqa: F401 (a hook of pytest)

if TYPE_CHECKING:
    from humanoid_bt.testing.rig import Rig


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the plugin's options in pytest's configuration file."""
    nearest = "the nearest folder above the test that is one, or pytest's root folder"
    parser.addini("humanoid_bt_workspace", f"folder with skills/, trees/, sim/ (default: {nearest})")
    parser.addini("humanoid_bt_robot", "robot that the rig simulates (default: humanoid)", default="humanoid")


@pytest.fixture(scope="session")
def _rigs() -> dict[Path, Rig]:
    """Keep the rig of each workspace, so that all its tests load the robot once."""
    return {}


@pytest.fixture
def rig(_rigs: dict[Path, Rig], request: pytest.FixtureRequest) -> Rig:
    """Give a real simulated robot, standing at the origin and looking along x, fresh for each test."""
    from humanoid_bt.testing.rig import Rig

    folder = _workspace(request)
    if folder not in _rigs:
        _rigs[folder] = Rig(folder, request.config.getini("humanoid_bt_robot"))
    _rigs[folder].reset()
    return _rigs[folder]


def _workspace(request: pytest.FixtureRequest) -> Path:
    from humanoid_bt.files.workspace import workspace_above

    root, named = request.config.rootpath, request.config.getini("humanoid_bt_workspace")
    return root / named if named else workspace_above(request.path.parent) or root
