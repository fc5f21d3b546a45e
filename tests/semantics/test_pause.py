"""Runs that are paused, stepped and changed by a person."""

from __future__ import annotations

from pathlib import Path

import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from humanoid_bt.core.messages import Gait, Mode
from tests.projects import make_project
from tests.semantics.claims import shows

WALK = """\
format: 1
scene: ball_on_stand
blackboard: {n: 0}
root:
  emergency_stop:
    sequence:
      - condition: state.mode == 'run' and n < 9
      - timeout: {duration: 0.6 s, reactive_sequence: [{condition: state.mode == 'run'}, walk: ]}
"""


@pytest.fixture
def session(tmp_path: Path) -> hbt.Session:
    root = make_project(tmp_path / "project")
    (root / "trees" / "walks.yaml").write_text(WALK.replace("walk: ]", "walk]"), encoding="utf-8")
    return hbt.Session("walks", workspace=root)


def statuses(session: hbt.Session) -> list[Status]:
    return [node.status for node in session.tree.nodes]


@shows("pause-nothing", "pause-percepts", "time-clock")
def test_the_tree_and_its_clock_stand_still(session: hbt.Session) -> None:
    with session:
        session.run_until(0.2)
        before, then = statuses(session), session.time
        session.pause()
        session.wait(1.0)  # longer than the time-out
        assert statuses(session) == before
        assert session.percepts["target"].stamp == pytest.approx(then + 1.0, abs=0.1)
        assert session.percepts["target"].age == pytest.approx(session.time - session.percepts["target"].stamp)
        session.resume()
        session.run()
    changes = [c for c in session.report.timeline if c["path"].endswith("/walk")]
    assert [(c["status"], c["time"]) for c in changes] == [
        ("RUNNING", 0.0),
        ("INVALID", pytest.approx(0.6 + 1.0)),
    ]


@shows("pause-held", "pause-unseen")
def test_control_holds_the_robot_and_no_tick_sees_it(session: hbt.Session) -> None:
    with session:
        session.run_until(lambda s: s.state.gait is Gait.STEP)
        session.pause()
        session.wait(3.0)
        assert (session.state.mode, session.state.base_settled) == (Mode.PAUSED, True)
        assert session.state.gait is Gait.STAND
        session.step()
        assert (session.state.mode, session.node("walk").status) == (Mode.RUN, Status.RUNNING)
        session.wait(0.02)
        assert session.state.mode is Mode.PAUSED
    assert session.report.stops == []


@shows("pause-withheld", "break-after-tick")
def test_what_the_tick_before_a_pause_commands_is_withheld(session: hbt.Session) -> None:
    with session:
        session.break_at("walk")
        assert not session.run_until(1.0)
        assert session.time == 0.0
        assert session.node("walk").status is Status.RUNNING
        session.wait(0.1)
        assert not session.state.command_sources
        session.resume()
        session.step()
        assert list(session.state.command_sources) == ["base"]


@shows("pause-outranked")
def test_a_stop_outranks_a_pause(session: hbt.Session) -> None:
    with session:
        session.step()
        session.pause()
        session.wait(0.1)
        session.raise_estop("enough")
        assert not session.wait(0.1)
    assert session.report.outcome == "stopped"


@shows("pause-end")
def test_the_end_of_a_tree_is_kept_back(session: hbt.Session) -> None:
    with session:
        session.break_at("timeout=FAILURE")
        session.run_until(2.0)
        assert (session.node("timeout").status, session.outcome) == (Status.FAILURE, "")
        session.wait(0.1)
        session.resume()
        assert not session.step()
    assert session.outcome == "failure"


@shows("forced-result", "forced-below")
def test_a_forced_result(session: hbt.Session) -> None:
    with session:
        session.run_until(0.1)
        session.force("timeout", Status.SUCCESS)
        session.step()
    told = [(c["path"].rsplit("/", 1)[-1], c["status"]) for c in session.report.timeline if c["time"] > 0.11]
    halted = [(name, "INVALID") for name in ("condition", "walk", "reactive_sequence")]
    assert told[:4] == [*halted, ("timeout", "SUCCESS")]
    assert session.node("walk").feedback == "halted: forced to SUCCESS by program"
    assert session.outcome == "success"


@shows("set-read", "person-told")
def test_what_is_set_counts_when_it_is_read(session: hbt.Session) -> None:
    with session:
        session.run_until(0.1)
        session.set("timeout.duration", "0.2 s", source="keyboard")
        session.run()
    assert session.time == pytest.approx(0.2)
    (told,) = (e for e in session.report.events if "keyboard" in e["text"])
    assert told["text"] == "set walks/emergency_stop/sequence/timeout.duration = 0.2 s by keyboard"
