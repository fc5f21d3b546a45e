"""Who is silent, control or decision itself, told apart without a wall clock."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from humanoid_bt.control.body.standing import load_robot
from humanoid_bt.core.errors import ControlLost
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.link.run_folder import RunFolder, RunInfo
from humanoid_bt.plant.scene import Scene, load_scene
from humanoid_bt.realtime import channels, decision_side
from humanoid_bt.realtime.decision_side import Realtime
from tests.tree.helpers import make_state


class Played:
    """Decision's side of a run whose control and clock the test plays.

    Attributes:
        now: the time [s].
        stands_still: how long this process stands still as soon as it has read what there was [s].
        speaks: whether control has something new to say.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        workspace = Workspace(builtin_root())
        robot, _ = load_robot(Path(workspace.find_robot("humanoid")))
        self.engine: Any = Realtime(robot, Scene(load_scene(workspace.find_scene("empty")), 0))
        self.now, self.stands_still, self.speaks, self.ended = 100.0, 0.0, True, ""
        clock = SimpleNamespace(monotonic=lambda: self.now, sleep=self._sleep)
        monkeypatch.setattr(decision_side, "time", clock)
        monkeypatch.setattr(self.engine, "_follow_readers", self._read)
        self.engine._schedule = SimpleNamespace(wait=lambda: self._sleep(0.02))
        self.engine._children = SimpleNamespace(how_ended=lambda _: self.ended, end=lambda: None)
        self.engine._state = make_state(1.0)
        self.engine._state_at = self.now

    def _sleep(self, duration: float) -> None:
        self.now += duration

    def _read(self) -> None:
        if self.speaks:
            self.engine._state_at = self.now
        self.now += self.stands_still


@pytest.fixture
def played(monkeypatch: pytest.MonkeyPatch) -> Played:
    return Played(monkeypatch)


def test_a_decision_that_stood_still_does_not_take_that_for_controls_silence(played: Played) -> None:
    played.stands_still = 2.0
    for _ in range(3):
        played.engine.sense()


def test_control_that_says_nothing_is_lost(played: Played) -> None:
    played.speaks = False
    with pytest.raises(ControlLost, match="silent for more than 1 s"):
        for _ in range(100):
            played.engine.sense()
    assert 101.0 < played.now < 101.1


def test_a_decision_that_stands_still_at_the_end_waits_for_control_all_the_same(
    played: Played, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    played.stands_still = 2.0
    looks: list[float] = []

    def how_ended(_: str) -> str:
        looks.append(played.now)
        return "exit code 0" if len(looks) > 5 else ""

    folder = SimpleNamespace(path=lambda name: tmp_path / name)
    monkeypatch.setattr(decision_side.channels, "quit_flag", lambda _: SimpleNamespace(beat=lambda: None))
    children = SimpleNamespace(how_ended=how_ended, end=lambda: None)
    played.engine._end(folder, children)
    assert len(looks) == 6


def test_control_that_says_nothing_at_the_end_is_not_waited_for(
    played: Played, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    played.speaks, ended = False, []

    def how_ended(_: str) -> str:
        assert played.now < 110.0, "waits for ever"
        return ""

    monkeypatch.setattr(decision_side.channels, "quit_flag", lambda _: SimpleNamespace(beat=lambda: None))
    children = SimpleNamespace(how_ended=how_ended, end=lambda: ended.append(played.now))
    played.engine._end(SimpleNamespace(path=lambda name: tmp_path / name), children)
    assert 101.0 <= ended[0] < 101.2


@pytest.mark.parametrize(("left", "ended"), [(False, ""), (True, ""), (False, "killed by SIGKILL")])
def test_who_abandons_control_when_it_has_just_left_cleans_up(
    played: Played, tmp_path: Path, left: bool, ended: str
) -> None:
    played.ended = ended
    engine, folder = played.engine, RunFolder.create(RunInfo("tree", "robot"), tmp_path / "runs")
    channels.create_channels(folder)
    if left:
        channels.leave(folder)
    engine._folder = folder

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    engine._end = interrupted
    with pytest.raises(KeyboardInterrupt):
        engine.close()
    assert folder.folder.exists() is not (left or bool(ended))
    if folder.folder.exists():
        assert channels.quit_flag(folder).count >= channels.ABANDONED
    folder.close()
