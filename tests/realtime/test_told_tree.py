"""What is told of a tree to who looks from outside, as far as there is room."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import humanoid_bt as hbt
from humanoid_bt.realtime.live_tree import TreeTeller


class Ring:
    slot_size = 16384

    def write(self, data: bytes) -> None:
        self.data = data


@pytest.mark.parametrize("long", ["unseen", "percepts"])
def test_statuses_are_told_whatever_else_would_not_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, long: str
) -> None:
    ring = Ring()
    monkeypatch.setattr("humanoid_bt.realtime.channels.writer", lambda *_: ring)

    class Folder:
        def path(self, name: str) -> Path:
            return tmp_path / name

    folder: Any = Folder()
    status = {"time": 1.0, "unseen": {}, "percepts": {}} | {long: {f"tag_{number}": "no" * 20 for number in range(587)}}
    TreeTeller(folder).tell(status, hbt.load("fetch"))
    told = json.loads(ring.data)
    assert "statuses" in told
    assert long not in told
