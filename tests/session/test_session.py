"""A session as programs use it: stepped, watched, set, stopped, left."""

from __future__ import annotations

import gc
import math
import subprocess
import sys
import weakref
from collections.abc import Callable
from pathlib import Path

import pytest
from py_trees.common import Status

import humanoid_bt as hbt
from tests.session.helpers import last_time

COUNT = """\
format: 1
blackboard: {n: 0, last: 100}
root:
  while:
    condition: n < last
    sequence:
      - set_blackboard: {key: n, expression: n + 1}
      - set_blackboard: {key: found, value: cup}
      - wait: 100 ms
"""
SEES = "format: 1\nscene: ball_on_stand\nroot: {emergency_stop: walk}\n"


@pytest.fixture(autouse=True)
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(project)
    for name, text in {"count": COUNT, "sees": SEES}.items():
        (project / "trees" / f"{name}.yaml").write_text(text, encoding="utf-8")


# ---- stepping ------------------------------------------------------------------------------------------------------


def test_steps_make_the_same_run(tmp_path: Path) -> None:
    whole = hbt.run("walk", duration="400 ms")
    with hbt.Session("walk", duration=0.4) as session:
        steps = 0
        while session.step():
            steps += 1
            assert session.time == pytest.approx(0.02 * (steps - 1))
            assert session.outcome == ""
    assert steps == 20
    assert session.outcome == session.report.outcome == "unfinished"
    assert session.report.trace_hash == whole.trace_hash


def test_what_it_shows_is_what_the_last_step_saw() -> None:
    with hbt.Session("sees") as session:
        assert (session.time, dict(session.percepts)) == (0.0, {})
        assert session.run_until(0.5)
        assert session.state.time == session.time == pytest.approx(0.5)
        target = session.percepts["target"]
        assert (target.distance, target.confidence) == (pytest.approx(1.95, abs=0.05), pytest.approx(0.9, abs=0.1))
        assert "1.9" in repr(target)
        walk = session.node("walk")
        assert (walk.status, walk.feedback) == (Status.RUNNING, "walking")
        assert session.node("sees/emergency_stop").path == "sees/emergency_stop"
        before = session.state
    assert session.state is before
    assert session.percepts["target"].age == target.age


def test_it_runs_until_something_holds_or_time_is_up_or_it_ends() -> None:
    with hbt.Session("wait") as session:
        assert session.run_until(lambda s: s.node("pause").status is Status.RUNNING)
        assert session.time == 0.0
        assert session.run_until(0.0)
        assert session.time == 0.0
        assert not session.run_until(lambda s: False, timeout=0.1)
        assert session.time == pytest.approx(0.1)
        assert not session.run_until(5.0)
        assert session.outcome == "success"


def test_time_counts_from_the_first_tick() -> None:
    with hbt.Session("walk", duration=0.1) as session:
        for _ in range(10):  # in realtime mode control runs before the first tick
            session.engine.advance()
        report = session.run()
    assert (report.outcome, report.sim_time) == ("unfinished", pytest.approx(0.1))
    assert report.wall_time < 5.0


def test_run_goes_on_where_steps_have_led() -> None:
    with hbt.Session("wait") as session:
        session.run_until(0.1)
        report = session.run()
        assert report is session.report
    assert (report.outcome, report.sim_time) == ("success", 0.2)


def test_the_blackboard_is_read_and_set() -> None:
    with hbt.Session("count") as session:
        board = session.blackboard
        assert dict(board) == {"n": 0, "last": 100}
        assert repr(board) == "{n: 0.0, last: 100.0, found: (not set)}"
        assert "found" not in board and board.get("found") is None
        board["last"] = 50
        session.step()
        assert session.blackboard["last"] == 50
        assert session.blackboard["found"] == "cup"
        session.blackboard["last"] = 2
        del session.blackboard["found"]
        assert session.run().outcome == "success"
    assert session.blackboard["n"] == 2


def test_what_is_deleted_before_the_first_step_begins_without_a_value() -> None:
    Path("trees/held.yaml").write_text("format: 1\nblackboard: {a: 1}\nroot: {sequence: [condition: true, running]}\n")
    with hbt.Session("held") as session:
        del session.blackboard["a"]
        session.step()
        assert "a" not in session.blackboard


def test_a_push_moves_it_and_is_told() -> None:
    def sway(force: float) -> tuple[float, float]:
        with hbt.Session("wait") as session:
            session.step()
            session.push((0.0, force, 0.0), duration=0.1)
            session.run()
        return abs(session.engine.sense()[0].base_position[1]), session.report.external_force_max

    assert sway(60.0)[0] > sway(0.0)[0] + 1e-4
    assert sway(60.0)[1] == 60.0


def test_a_stop_is_raised() -> None:
    with hbt.Session("walk", duration=3.0) as session:
        session.run_until(0.5)
        session.raise_estop("too near")
        session.step()
        assert (session.state.mode, session.state.stop_source) == (hbt.Mode.EMERGENCY_STOP, "program")
    (stop,) = session.report.stops
    assert (stop["time"], stop["reason"], session.outcome) == (pytest.approx(0.5), "too near", "stopped")


def test_a_reset_lets_a_run_that_waits_go_on(project: Path) -> None:
    tree = "format: 1\nroot: {emergency_stop: pause}\n"
    (project / "trees" / "safe.yaml").write_text(tree, encoding="utf-8")
    with hbt.Session("safe", on_estop="wait") as session:
        session.raise_estop(source="button")
        assert session.run_until(lambda s: s.state.mode is hbt.Mode.EMERGENCY_STOP)
        session.run_until(session.time + 0.1)
        session.request_reset(source="key")
        assert session.run().outcome == "success"


# ---- leaving -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "reason"),
    [
        pytest.param(None, "the session was left", marks=pytest.mark.trials),
        (ZeroDivisionError("oh"), "ZeroDivisionError: oh"),
    ],
)
def test_leaving_brings_the_robot_to_a_stand(tmp_path: Path, error: Exception | None, reason: str) -> None:
    recording = tmp_path / "walk.rrd"
    session = hbt.Session("walk", record=recording, camera=False)
    try:
        with session:
            session.run_until(1.0)
            if error:
                raise error
    except ZeroDivisionError as raised:
        assert raised is error
    report = session.report
    assert report.outcome == ("interrupted" if error else "unfinished")
    assert report.reason.startswith(reason)
    assert (report.sim_time, report.stops) == (1.0, [])
    assert session.engine.sense()[0].base_settled
    assert last_time(recording) > 1.1


def test_a_session_that_was_never_stepped_is_closed_too(tmp_path: Path) -> None:
    with hbt.Session("walk", record=str(tmp_path / "walk.rrd"), camera=False) as session:
        pass
    assert (session.report.outcome, session.report.sim_time) == ("unfinished", 0.0)
    assert last_time(tmp_path / "walk.rrd") == 0.0
    before = session.report
    session.close()
    assert session.report is before, "twice is once"


FORKS = """
import os, sys
import humanoid_bt as hbt

with hbt.Session("fetch", record="forked.rrd") as session:
    session.step()
    child = os.fork()
    if not child:
        sys.exit(0)
    print("child", os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))
    session.step()
print(session.report.outcome)
"""


@pytest.mark.trials
def test_a_forked_process_that_leaves_the_session_closes_nothing(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", FORKS], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (done.stdout.splitlines(), done.returncode) == (["child 0", "unfinished"], 0), done.stderr
    assert "Traceback" not in done.stderr


def test_an_exception_in_a_skill_is_an_end_and_not_raised() -> None:
    with hbt.Session("raise") as session:
        while session.step():
            pass
        assert (session.outcome, session.time) == ("error", pytest.approx(1.0))
    assert "KeyError: 'missing'" in session.report.traceback
    assert [stop["mode"] for stop in session.report.stops] == ["protective_stop"]


def test_it_is_interrupted_from_elsewhere() -> None:
    with hbt.Session("walk") as session:
        session.run_until(0.1)
        session.interrupt("the door opened")
        assert not session.step()
    report = session.report
    assert (report.outcome, report.reason, report.sim_time) == ("interrupted", "the door opened", 0.1)


def test_a_recording_is_made_only_if_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, project: Path) -> None:
    monkeypatch.chdir(tmp_path)
    assert hbt.run("wait", workspace=str(project)).recording is None
    assert list(tmp_path.iterdir()) == []
    recording = hbt.run("wait", workspace=project, record=True).recording
    assert recording is not None and recording.startswith("runs/wait-")
    assert Path(recording).is_file()


# ---- mistakes ------------------------------------------------------------------------------------------------------


def use(*calls: Callable[[hbt.Session], object]) -> Callable[[hbt.Session], object]:
    return lambda session: [call(session) for call in calls][-1]


@pytest.mark.parametrize(
    ("misuse", "message"),
    [
        (lambda s: s.step(), "the session has not begun: use it as 'with session:', or call start()"),
        (lambda s: s.run_until(1.0), "the session has not begun"),
        (lambda s: s.state, "the robot's state is there after the first step()"),
        (lambda s: s.report, "the report is there after run(), after the 'with' block or after close()"),
        (use(lambda s: s.start(), lambda s: s.run_until(9.0), lambda s: s.report), "the run has ended (success), and"),
        (use(lambda s: s.run(), lambda s: s.raise_estop()), "of 'wait' has been left: nothing can be stopped any more"),
        (use(lambda s: s.run(), lambda s: s.request_reset()), "nothing can be reset any more"),
        (use(lambda s: s.run(), lambda s: s.push((0, 1, 0))), "nothing can be pushed any more"),
        (use(lambda s: s.run(), lambda s: s.step()), "has ended (success): a new Session runs it again"),
        (use(lambda s: s.run(), lambda s: s.run()), "has begun before: it runs once, make a new one"),
        (use(lambda s: s.start(), lambda s: s.__enter__()), "has begun before"),
        (lambda s: s.run_until("soon"), "'condition' must be a time [s] or a function of the session, not 'soon'"),
        (lambda s: s.run_until(True), "'condition' must be a time"),
        (lambda s: s.run_until(math.nan), "'condition' must be a time"),
        (lambda s: s.run_until(1.0, timeout=-1), "'timeout' must be a number of seconds, 0 or more, not -1"),
        (lambda s: s.node("paus"), "has no node 'paus' [unknown-node]\n    did you mean 'pause'?"),
        (lambda s: s.blackboard["n"], "the tree has no key 'n'\n    the tree has no keys"),
        (lambda s: s.push("hard"), "'force' must be three numbers [N], not 'hard'"),
        (lambda s: s.push((0, 1e6, 0)), "'force' must be at most 10000 N in each direction, not 1000000.0"),
        (lambda s: s.push((0, 1, 0), duration=-1), "'duration' must be a number above 0, not -1"),
        (lambda s: s.push((0, 1, 0), body="arm"), "there is no body 'arm' to push"),
    ],
)
def test_misuse_is_one_clear_message(misuse: Callable[[hbt.Session], object], message: str) -> None:
    session = hbt.Session("wait")
    try:
        with pytest.raises(hbt.HumanoidBtError) as raised:
            misuse(session)
        assert message in str(raised.value)
    finally:
        session.close()


def test_a_key_takes_what_its_type_takes_until_the_run_has_ended() -> None:
    with hbt.Session("count", duration=0.1) as session:
        with pytest.raises(hbt.UserError, match=r"the blackboard's 'last': error: 'last' must be a number, not text"):
            session.blackboard["last"] = "soon"
        with pytest.raises(hbt.UserError, match=r"the blackboard's 'found': error: 'found' must be finite, not nan"):
            session.blackboard["found"] = float("nan")
        assert session.blackboard["last"] == 100
        session.run_until(1.0)
        with pytest.raises(hbt.HumanoidBtError, match="the run has ended: the key 'last' cannot be set"):
            session.blackboard["last"] = 1


def test_an_unknown_key_is_told_with_the_nearest() -> None:
    board = hbt.Session("count").blackboard
    with pytest.raises(KeyError, match="did you mean 'found'"):
        board["foud"] = 3
    with pytest.raises(KeyError, match="the key 'found' has no value yet"):
        board["found"]


def test_two_nodes_of_one_name_are_told_apart_by_their_paths(project: Path) -> None:
    (project / "trees" / "two.yaml").write_text("format: 1\nroot: {sequence: [pause, {repeat: {times: 2, pause: }}]}\n")
    tree = hbt.load("two")
    assert tree.node("repeat/pause") is tree.nodes[-1]
    with pytest.raises(hbt.UserError, match="2 nodes of the tree 'two' have paths that end with 'pause'"):
        tree.node("pause")


# ---- trees that are loaded already ---------------------------------------------------------------------------------


def test_a_loaded_tree_runs_once_where_it_is_from(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, project: Path
) -> None:
    (project / "sim" / "scenes").mkdir(parents=True, exist_ok=True)
    (project / "sim" / "scenes" / "hall.yaml").write_text("format: 1\nname: hall\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    tree = hbt.load(project / "trees" / "wait.yaml")
    assert repr(tree) == f"<Tree 'wait': 2 nodes, {project / 'trees' / 'wait.yaml'}>"
    assert hbt.run(tree, scene="hall").scene == "hall"
    with pytest.raises(hbt.UserError, match="was in a session before, and its nodes remember"):
        hbt.run(tree)


def test_a_loaded_tree_takes_no_parameters_and_is_not_watched() -> None:
    tree = hbt.load("fetch", reach_distance="45 cm")
    assert tree.parameters["reach_distance"] == 0.45
    with pytest.raises(hbt.UserError, match="is loaded already") as raised:
        hbt.run(tree, reach_distance=0.4, watch=True)
    assert "load('" in raised.value.problems[0].hint and "reach_distance=0.4)" in raised.value.problems[0].hint
    assert "'watch' needs the file of a tree" in raised.value.problems[1].message


# ---- reports -------------------------------------------------------------------------------------------------------


def test_a_simulation_goes_with_its_session_also_if_the_tree_is_kept() -> None:
    tree = hbt.load("sees")
    gc.disable()
    try:
        with hbt.Session(tree, duration=0.1) as session:
            session.step()
        engine = weakref.ref(session._drive.engine)
        del session
        assert engine() is None
    finally:
        gc.enable()


def test_a_report_is_a_few_lines_and_a_table_in_a_notebook() -> None:
    report = hbt.run("give_up")
    lines = repr(report).splitlines()
    assert lines[:2] == ["give_up on humanoid in empty, seed 0", "failure: give_up: the thing is not there"]
    assert len(lines) < 10
    assert report._repr_html_().startswith("<table><caption>give_up on humanoid in empty, seed 0</caption><tr>")
    assert "<tr><th>stops</th><td>none</td></tr>" in report._repr_html_()


def test_what_a_table_shows_is_escaped(project: Path) -> None:
    (project / "trees" / "odd.yaml").write_text('format: 1\nname: "<b>"\nroot: {wait: 20 ms}\n', encoding="utf-8")
    assert "&lt;b&gt; on humanoid" in hbt.run("odd")._repr_html_()


@pytest.mark.trials
@pytest.mark.realtime
def test_realtime_is_stepped_in_the_same_way(tmp_path: Path) -> None:
    with hbt.Session("walk", mode="realtime", duration=5.0, record=tmp_path / "walk.rrd", camera=False) as session:
        assert session.run_until(0.4)
        assert session.time >= 0.4
        assert session.node("walk").status is Status.RUNNING
        with pytest.raises(hbt.UserError, match="cannot be pushed in realtime mode"):
            session.push((0, 1, 0))
        session.raise_estop("enough")
        assert session.run_until(lambda s: s.state.mode is hbt.Mode.EMERGENCY_STOP, timeout=2.0)
    assert session.report.outcome == "stopped"
    assert [stop["reason"] for stop in session.report.stops] == ["enough"]
    assert last_time(tmp_path / "walk.rrd") > 0.4


def test_a_percept_that_was_not_seen_is_answered_with_what_was() -> None:
    with hbt.Session("fetch") as session:
        session.run_until(lambda s: "target" in s.percepts, timeout=1.0)
        with pytest.raises(KeyError, match="no percept 'taget' was seen so far\n    did you mean 'target'"):
            session.percepts["taget"]
        assert session.percepts.get("taget") is None
