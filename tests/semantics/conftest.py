from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.projects import make_project
from tests.tree.helpers import make_workspace


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    """A workspace with the small skills of ``tests.tree.helpers``."""
    return make_workspace(tmp_path / "project")


@pytest.fixture(scope="session")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's project folder, for whole runs."""
    return make_project(tmp_path_factory.mktemp("user") / "project")
