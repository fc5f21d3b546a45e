"""The pytest plugin: the ``rig`` fixture."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from humanoid_bt.testing.rig import Rig


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the plugin's options in pytest's configuration file."""
    parser.addini("humanoid_bt_workspace", "folder with skills/, trees/, sim/ (default: pytest's root folder)")
    parser.addini("humanoid_bt_robot", "robot that the rig simulates (default: humanoid)", default="humanoid")


@pytest.fixture(scope="session")
def _rig(pytestconfig: pytest.Config) -> Rig:
    """Load the robot once for all tests."""
    from humanoid_bt.files.workspace import Workspace
    from humanoid_bt.testing.rig import Rig

    folder = pytestconfig.getini("humanoid_bt_workspace")
    workspace = Workspace(pytestconfig.rootpath / folder if folder else pytestconfig.rootpath)
    return Rig(workspace, pytestconfig.getini("humanoid_bt_robot"))


@pytest.fixture
def rig(_rig: Rig) -> Iterator[Rig]:
    """Give a real simulated robot, standing at the origin and looking along x, fresh for each test."""
    _rig.reset()
    yield _rig
