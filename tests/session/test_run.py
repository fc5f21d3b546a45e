"""Whole runs in lockstep, with their recordings and reports."""

from __future__ import annotations

import json
from pathlib import Path

import pyarrow as pa
import pytest
import rerun as rr
from py_trees.common import Status

from humanoid_bt.control.supervisor import Supervisor
from humanoid_bt.core.errors import UserError
from humanoid_bt.robot.config import FallConfig
from humanoid_bt.session.session import Session
from humanoid_bt.session.trace import Trace
from humanoid_bt.tree.ticking.executor import NodeChange
from tests.session.helpers import Ran, Told, after, play, ran

NEAR = """
format: 1
name: near
objects: {ball: {shape: ball, size: [8 cm], position: [0.7, 0.05, 0.85]}}
percepts: {target: {object: ball}}
events: [{at: 0.5, hide: ball}, {at: 1.5, show: ball}]
"""


@pytest.fixture(scope="module")
def fetched(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """The demo with its ball at hand, lost and seen again at once."""
    scene = project / "sim" / "scenes" / "near.yaml"
    scene.parent.mkdir(parents=True)
    scene.write_text(NEAR, encoding="utf-8")
    return ran("fetch", project, tmp_path_factory.mktemp("fetch") / "fetch.rrd", scene="near")


@pytest.fixture(scope="module")
def raised(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return ran("raise", project, tmp_path_factory.mktemp("raise") / "raise.rrd")


@pytest.fixture(scope="module")
def interrupted(project: Path, tmp_path_factory: pytest.TempPathFactory) -> Ran:
    return ran("walk", project, tmp_path_factory.mktemp("walk") / "walk.rrd", after(60, "Ctrl-C"))


def last_sample(recording: Path) -> float:
    """Return the last time [s] that the recording has anything at."""
    last = 0.0
    for chunk in rr.chunk.RrdReader(recording).stream():
        batch = chunk.to_record_batch()
        if "sim_time" in batch.schema.names:
            last = max(last, *(time / 1e9 for time in batch.column("sim_time").cast(pa.int64()).to_pylist()))
    return last


@pytest.mark.trials
def test_the_demo_ends_with_a_hand_on_the_target(fetched: Ran) -> None:
    report = fetched.report
    assert (report.outcome, report.exit_code) == ("success", 0)
    assert report.reason.startswith("reach: ")
    assert report.result("hand_error") < 0.02
    assert not report.fell
    assert report.stops == []
    assert fetched.settled


def test_a_tree_that_is_made_for_use_in_others_is_refused(project: Path) -> None:
    with pytest.raises(UserError, match="does not run alone") as raised:
        ran("recover", project)
    assert raised.value.problems[0].hint == "in another one: subtree: {tree: recover, action: ...}"


def test_nothing_but_the_world_holds_the_robot(fetched: Ran) -> None:
    assert fetched.report.external_force_max == 0


def test_the_timeline_tells_every_change_in_order(fetched: Ran) -> None:
    timeline = fetched.report.timeline
    assert [entry["time"] for entry in timeline] == sorted(entry["time"] for entry in timeline)
    assert timeline[-1]["time"] <= fetched.report.sim_time
    ended = [entry for entry in timeline if entry["path"].endswith("/reach") and entry["status"] == "SUCCESS"]
    assert len(ended) == 1
    assert ended[0]["time"] == fetched.report.sim_time


def test_the_scene_tells_its_events_once_and_on_time(fetched: Ran) -> None:
    scene = [(time, text) for time, _, text in fetched.told.events if text.startswith("scene: ")]
    assert scene == [(0.5, "scene: ball hidden"), (1.5, "scene: ball shown")]


def test_the_report_is_json(fetched: Ran, tmp_path: Path) -> None:
    file = tmp_path / "report.json"
    fetched.report.write(file)
    report = json.loads(file.read_text(encoding="utf-8"))
    expected = {"outcome", "exit_code", "sim_time", "wall_time", "real_time_factor", "trace_hash", "timeline"}
    expected |= {
        "results",
        "events",
        "blackboard",
        "percepts",
        "unseen",
        "fell",
        "stops",
        "external_force_max",
        "recording",
        "parameters",
        "versions",
        "seed",
    }
    assert expected <= report.keys()
    assert report["exit_code"] == 0
    assert report["real_time_factor"] == pytest.approx(report["sim_time"] / report["wall_time"])
    assert Path(report["recording"]) == fetched.recording


def test_the_recording_covers_the_run(fetched: Ran) -> None:
    assert fetched.recording is not None
    assert last_sample(fetched.recording) >= fetched.report.sim_time - 0.05


def test_a_failing_tree_says_why(project: Path) -> None:
    report = ran("give_up", project).report
    assert (report.outcome, report.exit_code) == ("failure", 1)
    assert report.reason == "give_up: the thing is not there"


def test_a_tree_that_goes_on_is_unfinished(project: Path) -> None:
    report = ran("wait", project, duration=0.1).report
    assert (report.outcome, report.exit_code, report.sim_time) == ("unfinished", 5, 0.1)


@pytest.mark.trials
def test_a_run_that_waits_for_a_reset_goes_on_after_it(project: Path) -> None:
    told = Told()
    session = Session("walk", duration=5.0, workspace=project, on_estop="wait", listener=told)
    ticks = 0

    def press() -> str:
        nonlocal ticks
        ticks += 1
        if ticks == 20:
            session.raise_estop("pressed by hand", source="button")
        if ticks == 170:
            session.request_reset(source="key")
        return ""

    report = play(session, press)
    assert (report.outcome, [stop["source"] for stop in report.stops]) == ("unfinished", ["button"])
    texts = [text for _, _, text in told.events]
    how = "waiting for a reset: key r or 'humanoid-bt reset'; q or Ctrl-C ends the run"
    assert f"emergency stop: pressed by hand (button); {how}" in texts
    assert "reset by key: done" in texts
    walked = [entry["time"] for entry in report.timeline if entry["path"].endswith("/walk")]
    assert walked == pytest.approx([0.0, 0.4, 3.4, 5.0], abs=0.05)


def test_a_node_raises_the_emergency_stop(project: Path) -> None:
    tree = project / "trees" / "panic.yaml"
    root = "emergency_stop: {sequence: [pause, {raise_emergency_stop: {reason: too warm}}]}"
    tree.write_text(f"format: 1\nroot: {{{root}}}\n", encoding="utf-8")
    report = ran("panic", project).report
    path = "panic/emergency_stop/sequence/raise_emergency_stop"
    assert (report.outcome, report.reason) == ("stopped", f"too warm ({path})")
    assert report.stops[0]["source"] == path


def test_an_emergency_stop_ends_the_run(project: Path) -> None:
    told = Told()
    session = Session("walk", workspace=project, listener=told)
    ask = after(20, "pressed")

    def press() -> str:
        if ask():
            session.engine.supervisor.raise_estop("button", "pressed by hand")
        return ""

    report = play(session, press)
    assert (report.outcome, report.exit_code) == ("stopped", 3)
    assert report.reason == "pressed by hand (button)"
    assert [stop["mode"] for stop in report.stops] == ["emergency_stop"]
    assert report.stops[0]["commanded_by"] == {"base": "walk/emergency_stop/walk"}
    assert session.engine.sense()[0].base_settled
    told_at = [time for time, level, text in told.events if level == "error" and "pressed by hand" in text]
    assert told_at == [report.stops[0]["time"]]


def test_an_exception_names_node_tree_and_skill(raised: Ran, project: Path) -> None:
    report = raised.report
    assert (report.outcome, report.exit_code) == ("error", 4)
    line = 1 + (project / "skills/mine.py").read_text(encoding="utf-8").splitlines().index(
        '            raise KeyError("missing")'
    )
    assert f"{project / 'trees/raise.yaml'}:3:" in report.reason
    assert "'raise/emergency_stop/walk' raised KeyError: 'missing'" in report.reason
    assert f"raised at {project / 'skills/mine.py'}:{line}:" in report.reason
    assert "KeyError: 'missing'" in report.traceback


def test_after_an_exception_the_robot_stands_and_the_recording_is_whole(raised: Ran) -> None:
    assert raised.settled
    assert [stop["mode"] for stop in raised.report.stops] == ["protective_stop"]
    assert raised.recording is not None
    assert last_sample(raised.recording) > raised.report.sim_time


def test_an_interrupted_robot_stands_and_the_recording_is_whole(interrupted: Ran) -> None:
    report = interrupted.report
    assert (report.outcome, report.reason, report.exit_code) == ("interrupted", "Ctrl-C", 130)
    assert interrupted.settled
    assert report.stops == []
    assert interrupted.recording is not None
    assert last_sample(interrupted.recording) > report.sim_time
    assert interrupted.told.changes[-1].time == pytest.approx(report.sim_time)


def test_a_second_interruption_ends_at_once_and_still_reports(project: Path, tmp_path: Path) -> None:
    done = ran("hang", project, tmp_path / "hang.rrd")
    assert done.report.exit_code == 130
    assert "skills/mine.py" in done.report.reason
    assert "'hang/emergency_stop/hang'" in done.report.reason
    assert done.recording is not None
    assert last_sample(done.recording) == 0.0


_OTHERS = ("KeyboardInterrupt", "GeneratorExit", "CancelledError")


@pytest.mark.parametrize("error", ["SystemExit", *(pytest.param(error, marks=pytest.mark.trials) for error in _OTHERS)])
def test_a_skill_cannot_leave_the_program(project: Path, error: str) -> None:
    root = f"{{emergency_stop: {{leave: {{error: {error}, after: 0.5 s}}}}}}"
    (project / "trees" / "leaves.yaml").write_text(f"format: 1\nroot: {root}\n", encoding="utf-8")
    done = ran("leaves", project)
    assert done.report.exit_code == 4
    assert f"raised {error}: 7" in done.report.reason
    assert [stop["reason"] for stop in done.report.stops] == ["a node raised an exception"]
    assert done.settled


@pytest.mark.trials
def test_a_skill_that_raises_when_halted_is_an_error(project: Path) -> None:
    report = ran("stubborn", project, duration=0.1).report
    assert report.exit_code == 4
    assert "raised RuntimeError: not now" in report.reason


def test_an_error_of_our_own_still_brings_the_robot_to_a_stand(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = Told()

    def broken(_time: float, _running: str) -> None:
        told.ticks += 1
        if told.ticks == 60:
            raise ZeroDivisionError("a bug")

    monkeypatch.setattr(told, "progress", broken)
    session = Session("walk", workspace=project, listener=told)
    report = session.run()
    assert (report.outcome, report.exit_code) == ("error", 4)
    assert report.reason == "internal error: ZeroDivisionError: a bug"
    assert "in broken" in report.traceback
    assert session.engine.sense()[0].base_settled


def test_refused_commands_are_told_once_a_second(project: Path) -> None:
    told = ran("nowhere", project, duration=2.0).told
    refused = [text for _, _, text in told.events if text.startswith("refused")]
    assert refused[0].startswith("refused a command: the target of 'left_hand' is out of range")
    assert 2 <= len(refused) <= 3


def test_a_refused_setpoint_is_not_told_as_a_command(project: Path) -> None:
    told = Told()
    session = Session("fetch", duration=0.1, workspace=project, listener=told)
    session.engine.supervisor.rejected.append("setpoint at 0.020 s: the policy's answer is not finite")
    session.run()
    assert "refused a setpoint: the policy's answer is not finite" in [text for _, _, text in told.events]


def test_a_percept_that_never_comes_is_told(project: Path) -> None:
    told = Told()
    Session("fetch", scene="empty", duration=0.1, workspace=project, listener=told).run()
    assert (0.0, "warning", "the scene 'empty' publishes no percept 'target' (it publishes none)") in told.events


@pytest.mark.trials
def test_the_same_run_has_the_same_hash_and_another_seed_another(project: Path) -> None:
    hashes = [ran("fetch", project, seed=seed, duration=1.0).report.trace_hash for seed in (3, 3, 4)]
    assert hashes[0] == hashes[1] != hashes[2]


@pytest.mark.trials
def test_a_view_that_cannot_be_opened_is_a_mistake_only_if_asked_for(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DISPLAY", ":77")  # there is no such screen
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match="the viewer did not start: "):
        Session("give_up", view=True, record=True, workspace=project).run()
    assert list(Path("runs").iterdir()) == []
    told = Told()
    report = Session("give_up", view="auto", workspace=project, listener=told).run()
    assert report.outcome == "failure"
    assert told.events[0][2].startswith("no live view: the viewer did not start: ")


def test_what_nodes_tell_and_what_on_error_catches_are_events_of_the_run(project: Path) -> None:
    tree = project / "trees" / "talk.yaml"
    trying = "sequence: [{log: 'at {state.time}'}, {on_error: {walk: {raise_after: 0.1 s}}}]"
    root = f"{{emergency_stop: {{selector: [{{{trying}}}, {{log: {{text: over, level: warning}}}}]}}}}"
    tree.write_text(f"format: 1\nroot: {root}\n", encoding="utf-8")
    result = ran("talk", project)
    assert result.report.exit_code == 0
    first, caught, last = [event for event in result.told.events if "talk/" in event[2]]
    above = "talk/emergency_stop/selector"
    assert first == (0.0, "info", f"at 0 s  ({above}/sequence/log)")
    assert last == (caught[0], "warning", f"over  ({above}/log)")
    assert caught[0] == pytest.approx(0.1)
    assert caught[1] == "warning"
    assert f"the node '{above}/sequence/on_error/walk' raised KeyError: 'missing', raised at " in caught[2]
    assert caught[2].endswith(f"({above}/sequence/on_error)")


def test_a_run_of_hours_does_not_fill_the_memory() -> None:
    """A tree that flaps, events and refusals in every tick, for twenty minutes."""
    trace, supervisor = Trace(), Supervisor(FallConfig())
    for number in range(60_000):
        trace.node_changed(NodeChange(0.02 * number, "root/reach", Status.RUNNING, "on its way"))
        trace.events.append((0.02 * number, "info", "again"))
        supervisor.rejected.append("command")
    assert max(len(trace.timeline), len(trace.events)) <= 20_000
    assert len(supervisor.rejected) <= 1000
    assert trace.timeline.total == 60_000
    assert trace.timeline[0].time == 0.0
    assert trace.timeline[-1].time == pytest.approx(1200 - 0.02)
    assert trace.why() == "reach: on its way"
