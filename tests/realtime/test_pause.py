"""A pause in realtime mode: control holds the robot, decision goes on telling that it lives."""

from __future__ import annotations

from pathlib import Path

import pytest

import humanoid_bt as hbt
from humanoid_bt.core.messages import Gait, Mode

THERE_AND_ON = "format: 1\nroot: {emergency_stop: {timeout: {duration: 6 s, walk_to: {x: 0.3, y: 0}}}}\n"


@pytest.mark.realtime
def test_a_walking_robot_is_paused_and_goes_on_to_a_success(project: Path) -> None:
    (project / "trees" / "ahead.yaml").write_text(THERE_AND_ON, encoding="utf-8")
    with hbt.Session("ahead", workspace=project, mode="realtime") as session:
        session.run_until(lambda s: s.state.gait is Gait.STEP, timeout=20.0)
        session.pause("to look at it", source="a test")
        while not session.state.base_settled:
            assert session.wait(0.2)
        state = session.state
        assert (state.mode, state.stop_reason, state.stop_source) == (Mode.PAUSED, "to look at it", "a test")
        walks = session.node("walk_to").status
        session.step()
        assert session.state.mode is Mode.RUN
        session.resume()
        report = session.run()
    assert walks.name == "RUNNING"
    assert (report.outcome, report.fell, report.stops) == ("success", False, []), report.reason
    ran = [change["status"] for change in report.timeline if change["path"].endswith("/walk_to")]
    assert ran == ["RUNNING", "SUCCESS"]
