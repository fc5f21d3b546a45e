"""Whatever becomes of a process of a run, the robot stands, the run says so, and nothing is left behind."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from humanoid_bt.control.cycle_log import MODES
from humanoid_bt.core.messages import Gait, Mode
from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.link.run_folder import RunFolder, RunInfo, default_root
from humanoid_bt.realtime import channels
from humanoid_bt.realtime.channels import RunSpec
from humanoid_bt.record.reading import read_cycles
from humanoid_bt.review.explain import explain
from humanoid_bt.session.session import Session
from tests.realtime.helpers import PATIENCE, Live, command, told, until

pytestmark = pytest.mark.realtime
Start = Callable[..., Live]


def stands(run: Live) -> bool:
    return run.state.gait is Gait.STAND and run.state.mode is not Mode.DAMP


def is_whole(run: Live) -> bool:
    return sum(1 for _ in rr.chunk.RrdReader(run.recording).stream()) > 0


@pytest.mark.trials
def test_ctrl_c_brings_the_robot_to_a_stand_the_second_without_decision_and_two_runs_do_not_meet(live: Start) -> None:
    one, other = live("walk", wait=False), live("walk", wait=False)
    one.ready()
    other.ready()
    one.walks()
    one.process.send_signal(signal.SIGINT)
    assert one.ends() == 130
    assert one.report["reason"] == "Ctrl-C"
    assert other.process.poll() is None
    other.walks()
    other.process.send_signal(signal.SIGINT)
    until("the first one", lambda: "another Ctrl-C does not wait" in other.output)
    other.process.send_signal(signal.SIGINT)
    assert other.ends() == 130
    assert other.report["reason"] == "stopped at once; control brings the robot to a stand and ends by itself"
    assert other.log[-1]["text"] == "control ended: decision did not wait for it"
    for run in (one, other):
        assert run.report["outcome"] == "interrupted"
        assert run.state.base_settled
        assert stands(run)
        assert is_whole(run)


def test_a_killed_control_process_ends_the_run(live: Start) -> None:
    code = "from humanoid_bt.link.run_folder import *; print(RunFolder.create(RunInfo('t', 'r')).folder.name)"
    stale = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip()
    run = live("walk")
    assert not (default_root() / stale).exists()
    run.walks()
    run.kill("control")
    assert run.ends() == 4
    assert run.report["reason"] == "the control process ended (killed by signal 9)"
    told = explain(run.recording)
    assert re.fullmatch(
        r"control was lost at [\d.]+ s: the control process ended \(killed by signal 9\)", told.headline
    )
    assert told.node == "walk/emergency_stop/walk"
    assert "Traceback" not in run.output
    assert is_whole(run)


def test_without_perception_the_watchdog_holds_and_an_estop_from_outside_ends_it(live: Start) -> None:
    run = live("watched", "--on-estop", "end", record=False)
    run.walks()
    told_id, *_ = (line for line in run.output.splitlines() if " s " in line)
    assert told_id == f"   0.00 s • the id of this run, for estop, reset and status: {run.run_id}"
    run.kill("perception")
    ended = "the perception process ended (killed by signal 9)"
    until("the watchdog's branch", lambda: "▶ blind" in run.output.partition(ended)[2])
    done = command("estop", "--run", run.run_id, "--reason", "a test of it")  # by another process than this one
    assert (done.returncode, done.stderr) == (0, "")
    assert "emergency stop after" in done.stdout
    assert run.ends() == 3
    (stop,) = (stop for stop in run.report["stops"] if stop["mode"] == "emergency_stop")
    assert stop["reason"] == "a test of it"
    assert stop["source"].startswith("humanoid-bt estop (")
    assert stands(run)


def test_when_decision_is_killed_control_stops_holds_and_ends_by_itself(live: Start) -> None:
    run = live("walk", "--hold", "0.5")
    run.walks()
    run.process.kill()
    run.process.wait()
    until("the protective stop", lambda: run.state.mode is Mode.PROTECTIVE_STOP)
    run.leaves_nothing()
    stop = next(line for line in run.log if line["kind"] == "stop")
    assert stop["text"].startswith("protective_stop: decision silent")
    assert stop["commanded_by"] == {"base": "walk/emergency_stop/walk"}
    texts = [line["text"] for line in run.log]
    forgiven = any("stalled" in text for text in texts)  # silence counts from anew then
    silent = stop["time"] - stop["last_command"]
    assert silent < (0.35 if forgiven else 0.25)  # 0.1 s after it was heard, and it was stamped before its tick
    assert "decision died; control holds the robot for 0.5 s and ends" in texts
    assert texts[-1] == "control ended: decision died before"
    assert run.state.mode is Mode.PROTECTIVE_STOP
    assert run.state.base_settled  # however short it was to be held
    ended = run.log[-1]["time"]
    until("the end in the recording", lambda: read_cycles(run.recording).time[-1] > ended - 0.01)
    cycles = read_cycles(run.recording)
    assert (np.diff(cycles.columns["servo"][:, 0]) == 1).all()  # every one
    stopped = cycles.columns["servo"][:, 1] == MODES.index(Mode.PROTECTIVE_STOP)
    assert cycles.time[stopped][0] == pytest.approx(stop["time"], abs=0.002)
    found = explain(run.recording)
    killed = r"the program that runs the tree was killed after its tick of ([\d.]+) s while 'walk' ran; "
    told = re.fullmatch(killed + r"control stopped the robot at ([\d.]+) s", found.headline)
    assert told, found.headline
    assert float(told[2]) == pytest.approx(stop["time"], abs=0.002)
    assert "control ended: decision died before" in found.text()


@pytest.mark.trials
def test_a_stopped_decision_and_an_estop_are_waited_for(live: Start) -> None:
    run = live("walk")
    run.walks()
    until("status tells of ticks", lambda: " Hz" in told("status", "--run", run.run_id))  # after the command is given
    run.process.send_signal(signal.SIGSTOP)
    run.shows("protective_stop")
    until("status tells it", lambda: "no tick for" in told("status", "--run", run.run_id))
    run.process.send_signal(signal.SIGCONT)
    run.shows("run")
    assert "emergency stop after" in told("estop", "--run", run.run_id)
    assert "since before: raised by hand" in told("estop", "--run", run.run_id)
    until("the node waits", lambda: "waiting for a reset" in run.output)
    until("it is drawn", lambda: "; waiting for a reset" in told("show", "--live", "--run", run.run_id))
    assert told("reset", "--run", run.run_id).startswith("reset: raised by hand")
    run.shows("run")
    run.walks()
    run.process.send_signal(signal.SIGINT)
    assert run.ends() == 130
    stops = run.report["stops"]
    assert stops[0]["mode"] == "protective_stop" and "emergency_stop" in [stop["mode"] for stop in stops]
    assert stops[0]["commanded_by"] == {"base": "walk/emergency_stop/walk"}
    noted = [line["time"] for line in run.log if line["kind"] == "stop"]  # by control, while decision did not run
    assert [stop["time"] for stop in stops] == pytest.approx(noted[: len(stops)], abs=0.01)
    assert "reset by humanoid-bt reset (" in run.output


@pytest.mark.trials
def test_a_crash_in_a_skill_stops_the_robot(project: Path) -> None:
    session = Session("raise", workspace=project, mode="realtime")
    report = session.run()
    assert report.exit_code == 4
    assert "raised KeyError" in report.reason
    assert "a node raised an exception" in [stop["reason"] for stop in report.stops]
    assert report.timing is not None and report.timing["cycles"] > 1000  # it walked for a second


def spec(parent: int, hold: float = 0.2) -> RunSpec:
    workspace = Workspace(builtin_root())
    robot, scene = workspace.find_robot("humanoid"), workspace.find_scene("empty")
    return RunSpec(str(robot.resolve()), str(scene.resolve()), 0, None, "", hold, parent)


@pytest.mark.parametrize("module", ["control_process", "perception_process"])
def test_a_process_whose_parent_died_before_it_looked_ends(module: str) -> None:
    folder = RunFolder.create(RunInfo("tree", "robot"))
    try:
        spec(parent=1_000_000_000).write(folder)
        channels.create_channels(folder)
        run = [sys.executable, "-m", f"humanoid_bt.realtime.{module}", str(folder.folder)]
        assert subprocess.run(run, timeout=PATIENCE, check=False).returncode == 0
        assert folder.folder.exists() is (module == "perception_process")
    finally:
        folder.close()


def test_the_control_process_imports_no_trees_and_no_viewers() -> None:
    code = "import sys, humanoid_bt.realtime.control_process; print({'py_trees', 'rerun', 'rich'} & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "set()"
