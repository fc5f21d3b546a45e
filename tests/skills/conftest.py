from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import humanoid_bt as hbt


@pytest.fixture
def session_of(tmp_path: Path) -> Callable[[str], hbt.Session]:
    """Make the session of a tree with one node."""

    def make(node: str) -> hbt.Session:
        (tmp_path / "trees").mkdir()
        text = f"format: 1\nroot: {{emergency_stop: {{timeout: {{duration: 30 s, {node}}}}}}}\n"
        (tmp_path / "trees" / "t.yaml").write_text(text, encoding="utf-8")
        return hbt.Session("t", workspace=tmp_path)

    return make
