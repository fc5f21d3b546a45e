"""A pause in realtime mode: control holds the robot, decision goes on telling that it lives."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import humanoid_bt as hbt
from humanoid_bt.core.messages import Gait, Mode, State
from humanoid_bt.link.run_folder import live_runs
from humanoid_bt.link.wire import decode_state
from humanoid_bt.realtime import channels
from tests.realtime.helpers import environment, until

THERE_AND_ON = "format: 1\nroot: {emergency_stop: {timeout: {duration: 6 s, walk_to: {x: 0.3, y: 0}}}}\n"


def paused_walk(project: Path) -> hbt.Report:
    """Pause a robot in mid-walk, look at it when it stands, give it a tick, and let it go on."""
    with hbt.Session("ahead", workspace=project, mode="realtime") as session:
        session.run_until(lambda s: s.state.gait is Gait.STEP, timeout=20.0)
        session.pause("to look at it", source="a test")
        session.wait(0.2)
        while not session.state.base_settled:
            assert session.wait(0.2)
        state = session.state
        assert (state.mode, state.stop_reason, state.stop_source) == (Mode.PAUSED, "to look at it", "a test")
        assert session.node("walk_to").status.name == "RUNNING"
        session.step()
        assert session.state.mode is Mode.RUN
        session.resume()
        return session.run()


@pytest.mark.trials
@pytest.mark.realtime
def test_a_walking_robot_is_paused_and_goes_on_to_a_success(project: Path) -> None:
    (project / "trees" / "ahead.yaml").write_text(THERE_AND_ON, encoding="utf-8")
    report = paused_walk(project)
    assert (report.outcome, report.fell) == ("success", False), report.reason
    stalled = "decision silent"  # a machine that is busy elsewhere is none of the pause's
    assert [stop for stop in report.stops if not stop["reason"].startswith(stalled)] == []
    ran = [change["status"] for change in report.timeline if change["path"].endswith("/walk_to")]
    assert ran == ["RUNNING", "SUCCESS"]


PAUSED = """
import humanoid_bt as hbt
with hbt.Session("walk", mode="realtime", hold=1.0) as session:
    session.run_until(0.5)
    session.pause()
    while True:
        session.wait(1.0)
"""


@pytest.mark.trials
@pytest.mark.realtime
def test_decision_that_is_killed_while_paused_is_noticed(project: Path) -> None:
    decision = subprocess.Popen([sys.executable, "-c", PAUSED], cwd=project, env=environment())
    try:
        until("the run's start", lambda: any(info.processes["owner"] == decision.pid for _, info in live_runs()))
        folder = next(folder for folder, info in live_runs() if info.processes["owner"] == decision.pid)
        until("its states", lambda: folder.path("state").exists())
        states = channels.reader(folder, "state")

        def state() -> State | None:
            latest = states.latest()
            return decode_state(latest[1]) if latest else None

        until("the pause", lambda: (now := state()) is not None and now.mode is Mode.PAUSED)
        decision.kill()
        until("the stop", lambda: (now := state()) is not None and now.mode is Mode.PROTECTIVE_STOP)
        stopped = state()
        assert stopped is not None
        assert stopped.stop_reason.startswith("decision ")  # silent, and died
        until("the end", lambda: not folder.folder.exists())
        last = state()
        assert last is not None
        assert last.base_settled
    finally:
        decision.kill()
        decision.wait()
