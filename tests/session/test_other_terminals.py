"""A run in lockstep as other terminals reach it: seen, stopped, reset."""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from humanoid_bt.cli import main
from humanoid_bt.core.messages import Mode
from humanoid_bt.link import run_folder
from humanoid_bt.link.estop import EStop
from humanoid_bt.link.run_folder import RunFolder, live_runs, lockstep_root
from humanoid_bt.link.segment import LinkError
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.live_tree import TreeWatch
from humanoid_bt.session.session import Session
from tests.session.helpers import Told, ran


@pytest.fixture(autouse=True)
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let runs live elsewhere than those of a real robot do."""
    monkeypatch.setattr(run_folder, "default_root", lambda: tmp_path / "runs")


def folder_of(number: int = 0) -> RunFolder:
    return live_runs(lockstep_root())[number][0]


@contextmanager
def begun(project: Path, count: int = 1) -> Iterator[list[Session]]:
    """Begin runs that wait for resets, and tick them once."""
    sessions = [Session("walk", workspace=project, on_estop="wait", listener=Told()) for _ in range(count)]
    for session in sessions:
        session.start()
        session.step()
    yield sessions
    for session in sessions:
        session.close()


def command(*arguments: str, while_: Callable[[], object]) -> int:
    """Run a command as in another terminal, and do something until it is over; return its exit code."""
    codes: list[int] = []
    terminal = threading.Thread(target=lambda: codes.append(main(list(arguments))))
    terminal.start()
    while terminal.is_alive():
        while_()
    return codes[0]


def test_a_run_is_seen_while_it_is_on_and_leaves_nothing(project: Path) -> None:
    with begun(project) as (session,):
        session.run_until(0.4)
        info = folder_of().info
        assert (info.tree, info.robot, info.scene, info.recording) == ("walk", "humanoid", "empty", "")
        assert info.file == str(project / "trees/walk.yaml")
        seen = TreeWatch(folder_of()).latest()
        assert seen is not None
        assert {path: status.name for path, status in seen.statuses.items()} == {
            "walk/emergency_stop": "RUNNING",
            "walk/emergency_stop/walk": "RUNNING",
        }
        assert seen.feedback["walk/emergency_stop/walk"] == "walking"
    assert live_runs(lockstep_root()) == live_runs() == []


def test_a_run_for_which_there_is_no_room_in_memory_is_not_seen(
    project: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def full(path: Path) -> EStop:
        raise LinkError(f"{path} cannot be made: No space left on device")

    monkeypatch.setattr(EStop, "create", full)
    with begun(project):
        assert "other terminals can neither see nor stop this run" in caplog.text
        assert live_runs(lockstep_root()) == []


def test_an_estop_from_outside_stops_in_the_next_step_until_a_reset(project: Path) -> None:
    with begun(project) as (session,):
        session.run_until(0.2)
        estop = channels.estop(folder_of())
        estop.raise_("terminal", "in the way")
        session.step()
        assert (session.state.mode, session.state.stop_source) == (Mode.EMERGENCY_STOP, "terminal")
        ticket = estop.request_reset("terminal")
        session.step()
        assert session.state.mode is Mode.RUN
        estop.poll()
        answer = estop.answer_to(ticket)
        assert answer is not None and answer.accepted
        estop.close()


def test_a_reset_from_inside_clears_what_was_raised_outside(project: Path) -> None:
    with begun(project) as (session,):
        estop = channels.estop(folder_of())
        estop.raise_("terminal", "in the way")
        session.run_until(0.1)
        session.request_reset()
        session.run_until(0.3)
        assert session.state.mode is Mode.RUN
        estop.poll()
        assert estop.raised is None
        estop.raise_("terminal", "again")
        session.step()
        assert session.state.mode is Mode.EMERGENCY_STOP
        estop.close()


def test_an_estop_that_nobody_resets_ends_a_run_that_nobody_watches(project: Path) -> None:
    def press() -> str:
        estop = channels.estop(folder_of())
        estop.raise_("terminal", "in the way")
        estop.close()
        return ""

    report = ran("walk", project, interrupted=press).report
    assert (report.exit_code, report.reason) == (3, "in the way (terminal)")


@pytest.mark.trials
def test_the_commands(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with begun(project, 2) as sessions:

        def step() -> None:
            for session in sessions:
                session.step()

        assert command("estop", "--reason", "in the way", while_=step) == 0
        out = capsys.readouterr().out
        assert "2 robots are running: all of them are stopped" in out
        for number in (0, 1):
            name = folder_of(number).info.run_id
            assert f"walk on humanoid, lockstep ({name}): emergency stop after " in out
        assert main(["reset"]) == 2
        assert f"humanoid-bt reset --run {name}   # walk on humanoid, lockstep" in capsys.readouterr().err
        assert command("reset", "--run", name, while_=step) == 0
        assert capsys.readouterr().out.startswith("reset: in the way (humanoid-bt estop (")
        for _ in range(10):  # what it does is told every few ticks
            step()
        assert [session.state.mode for session in sessions] == [Mode.EMERGENCY_STOP, Mode.RUN]
        assert main(["status"]) == 0
        shown = " ".join(capsys.readouterr().out.split())
        assert "mode emergency stop: in the way" in shown and "mode run" in shown
        assert "servo" not in shown
        assert main(["status", "--json", "--run", name]) == 0
        (status,) = json.loads(capsys.readouterr().out)
        assert (status["mode"], status["node"], status["timing"]) == ("run", "walk/emergency_stop/walk", None)


def test_a_program_that_pauses_is_said_to_stop_with_its_next_step(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with begun(project) as (session,):
        assert main(["estop"]) == 4
        assert "its next step stops it" in capsys.readouterr().err
        session.step()
        assert session.state.mode is Mode.EMERGENCY_STOP
