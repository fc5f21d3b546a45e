from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import make_workspace


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    return make_workspace(tmp_path / "project")
