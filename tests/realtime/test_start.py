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
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime import decision_side
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.realtime.decision_side import Realtime


def test_a_control_process_that_does_not_come_up_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(run_folder, "default_root", lambda: tmp_path / "runs")
    monkeypatch.setattr(sys, "executable", "/bin/false")
    workspace = Workspace(builtin_root())
    robot, _ = load_robot(workspace.find_robot("humanoid"))
    realtime = Realtime(robot, Scene(load_scene(workspace.find_scene("empty")), 0))
    threads = threading.active_count()
    with pytest.raises(ControlLost, match=r"the control process ended \(exit code 1\)"):
        realtime.start(RunInfo("tree", "robot"))
    realtime.close()
    realtime.close()
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [".lock"]
    assert threading.active_count() == threads
    assert decision_side.live_runs(tmp_path / "runs") == []


@pytest.mark.parametrize(("beside", "core"), [(False, 7), (True, None)], ids=["alone", "two at once"])
def test_control_has_a_core_to_itself_only_if_no_other_run_begins(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, beside: bool, core: int | None
) -> None:
    create, others = RunFolder.create, list[RunFolder]()

    def begin(info: RunInfo) -> RunFolder:
        others.extend([create(info)] if beside else [])
        return create(info)

    monkeypatch.setattr(run_folder, "default_root", lambda: tmp_path / "runs")
    monkeypatch.setattr(sys, "executable", "/bin/false")
    monkeypatch.setattr(decision_side, "last_core", lambda: 7)
    monkeypatch.setattr(RunFolder, "create", begin)
    workspace = Workspace(builtin_root())
    robot, _ = load_robot(workspace.find_robot("humanoid"))
    realtime = Realtime(robot, Scene(load_scene(workspace.find_scene("empty")), 0))
    with pytest.raises(ControlLost):
        realtime.start(RunInfo("tree", "robot"))
    assert realtime._folder is not None
    assert RunSpec.read(realtime._folder).core == core
    realtime.close()
    for other in others:
        other.close()
