"""A run whose control does not come up says so and leaves nothing."""

from __future__ import annotations

import sys
import threading
from pathlib import Path

import pytest

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import ControlLost
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.link import run_folder
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime import decision_side
from humanoid_bt.realtime.decision_side import Realtime


def test_a_control_process_that_does_not_come_up_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_folder, "default_root", lambda: tmp_path / "runs")
    monkeypatch.setattr(sys, "executable", "/bin/false")
    workspace = Workspace(builtin_root())
    robot, _ = load_robot(workspace.find_robot("humanoid"))
    realtime = Realtime(robot, Scene(load_scene(workspace.find_scene("empty")), 0), "tree")
    threads = threading.active_count()
    with pytest.raises(ControlLost, match=r"the control process ended \(exit code 1\)"):
        realtime.start()
    realtime.close()
    realtime.close()
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [".lock"]
    assert threading.active_count() == threads
    assert decision_side.live_runs(tmp_path / "runs") == []
