"""The pytest plugin: the fixtures ``rig`` and ``source_rig``, and scenario files as tests."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING

import pytest

_PACKAGE = Path(__file__).resolve().parents[1]

pytest_plugins = ["humanoid_bt.testing.plugin_coverage", "humanoid_bt.testing.plugin_scenarios"]

if TYPE_CHECKING:
    from humanoid_bt.testing.rig import Rig
    from humanoid_bt.testing.source_rig import SourceRig


def pytest_addoption(parser: pytest.Parser) -> None:
    """Declare the plugin's options in pytest's configuration file."""
    nearest = "the nearest folder above the test that is one, or pytest's root folder"
    parser.addini("humanoid_bt_workspace", f"folder with skills/, trees/, sim/ (default: {nearest})")
    parser.addini("humanoid_bt_robot", "robot that the rig simulates (default: humanoid)", default="humanoid")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_makereport(item: pytest.Item, call: pytest.CallInfo[None]) -> None:
    """Show of a mistake the lines of the test and of its skill, and not the way through this package."""
    if call.excinfo is None or item.config.getoption("fulltrace"):
        return
    from humanoid_bt.core.errors import HumanoidBtError, UserError

    error = call.excinfo.value
    if not isinstance(error, HumanoidBtError):
        return
    from humanoid_bt.tree.ticking.executor import NodeError

    if isinstance(error, (UserError, NodeError)):
        _hide_own_frames(error.__traceback__)
        error.__cause__, error.__suppress_context__ = None, True
    if isinstance(error, NodeError) and (entry := _beyond_own_frames(error.error.__traceback__)):
        _hide_own_frames(entry)
        error.__cause__ = error.error.with_traceback(entry)


def _beyond_own_frames(entry: TracebackType | None) -> TracebackType | None:
    """Return where a traceback leaves this package, None if it does not."""
    while entry is not None and _is_own(entry):
        entry = entry.tb_next
    return entry


def _is_own(entry: TracebackType) -> bool:
    return Path(entry.tb_frame.f_code.co_filename).is_relative_to(_PACKAGE)


def _hide_own_frames(entry: TracebackType | None) -> None:
    """Take the frames of this package out of a traceback, but for those that pytest itself has called: fixtures."""
    while entry is not None:
        if "_pytest" not in Path(entry.tb_frame.f_code.co_filename).parts:
            while (inner := entry.tb_next) and _is_own(inner):
                entry.tb_next = inner.tb_next
        entry = entry.tb_next


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


@pytest.fixture(scope="session")
def _source_rigs() -> Iterator[dict[Path, SourceRig]]:
    """Keep the rig of each workspace, with its cameras, until all tests are over."""
    rigs: dict[Path, SourceRig] = {}
    yield rigs
    for rig in rigs.values():
        rig.close()


@pytest.fixture
def source_rig(_source_rigs: dict[Path, SourceRig], request: pytest.FixtureRequest) -> SourceRig:
    """Give percept sources something to look at: pictures, scenes, what was recorded."""
    from humanoid_bt.testing.source_rig import SourceRig

    folder = _workspace(request)
    if folder not in _source_rigs:
        _source_rigs[folder] = SourceRig(folder, request.config.getini("humanoid_bt_robot"))
    return _source_rigs[folder]


def _workspace(request: pytest.FixtureRequest) -> Path:
    from humanoid_bt.files.workspace import workspace_above

    root, named = request.config.rootpath, request.config.getini("humanoid_bt_workspace")
    return root / named if named else workspace_above(request.path.parent) or root
