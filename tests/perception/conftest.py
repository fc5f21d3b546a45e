from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.perception.sources import BAD, SIGN, write


@pytest.fixture
def workspace(tmp_path: Path) -> Workspace:
    write(tmp_path, "door_sign.py", SIGN)
    write(tmp_path, "bad.py", BAD)
    return Workspace(tmp_path)
