"""What stopped a robot on the wall clock."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.link.run_folder import live_runs
from humanoid_bt.review.explain import explain
from humanoid_bt.session.session import Session
from tests.review.test_causes import pressed

Play = Callable[..., Path]

pytestmark = pytest.mark.realtime


@pytest.mark.trials
def test_a_tick_that_takes_too_long_is_named_with_its_line(play: Play) -> None:
    found = explain(play("sleepy", duration=0.7, mode="realtime"))
    headline = r"one tick took 0\.[5-9]\d s at ([\d.]+) s in 'sleepy', skills/staged\.py:\d+: "
    told = re.match(headline + r"the robot was stopped at ([\d.]+) s", found.headline)
    assert told, found.headline
    assert found.kind == "slow_tick"
    assert found.node == "sleepy/emergency_stop/sleepy"
    assert 0.05 < float(told[2]) - float(told[1]) < 0.2


def end(session: Session, role: str) -> None:
    """Kill a process of a run of this one."""
    processes = next(info.processes for _, info in live_runs() if info.processes["owner"] == os.getpid())
    os.kill(processes[role], signal.SIGKILL)


def full(session: Session) -> None:
    """Let the recorder write a little more, and then nothing."""
    recorder: Any = session._drive._recorder
    file = session._drive._options.sinks.file
    assert file is not None
    limit = (file.stat().st_size + 20_000, resource.RLIM_INFINITY)
    resource.prlimit(recorder._process.pid, resource.RLIMIT_FSIZE, limit)


CASES: dict[str, tuple[str, str, dict[str, Any], str]] = {
    "estop by hand": (
        "walk",
        "estop",
        {"at": 3.0, "do": pressed, "on_estop": "end", "duration": 5.0},
        r"the emergency stop was raised at \d\.\d+ s by humanoid-bt estop \(me@pts/3, pid 4711\): too near",
    ),
    "percept lost": (
        "fails_when_lost",
        "percept_lost",
        {"at": 2.8, "do": lambda session: end(session, "perception"), "duration": 5.0},
        r"'target' was last seen at \d\.\d+ s, the perception process ended \(killed by signal 9\) at \d\.\d+ s: "
        r"'watchdog' failed at \d\.\d+ s",
    ),
    "percept doubtful, hidden by the scene": (
        "late_doubtful",
        "percept_doubtful",
        {"duration": 5.0},
        r"'confident' failed at (3\.[89]|4\.0)\d+ s: the percept was doubtful, confidence 0\.\d+ < 0\.5 "
        r"\(ball hidden at 3\.8\d s \(the scene's script\)\)",
    ),
    "flapping": (
        "late_flapping",
        "percept_doubtful",
        {"duration": 7.0},
        r"'confident' changed its mind \d times from \d\.\d+ to \d\.\d+ s: confidence .*, then confidence .*",
    ),
    "not finite": (
        "nan",
        "not_finite",
        {},
        r"'wild' raised ValueError: a target's position must be finite, not \[nan, 0\.0, 0\.0\] at \d\.\d+ s, in .*",
    ),
    "out of reach": (
        "far",
        "out_of_reach",
        {"duration": 6.0},
        r"'reach' failed at \d\.\d+ s: left hand comes no nearer than 1\d\d cm",
    ),
    "torque limit": (
        "far",
        "torque_limit",
        {"duration": 6.0, "robot": "weak"},
        r"'reach' failed at \d\.\d+ s: left hand comes no nearer than \d+ cm; "
        r"left_shoulder_\w+ was at its torque limit, 2 Nm",
    ),
    "push and fall": (
        "bumped",
        "push",
        {"duration": 6.0},
        r"the robot fell at \d\.\d+ s: something pushed it forward at 4\.[34]\d s",
    ),
    "exception": (
        "raise",
        "exception",
        {"duration": 3.0},
        r"'walk' raised KeyError: 'missing' at \d\.\d+ s, in .*mine\.py:\d+",
    ),
    "time-out": (
        "late",
        "timeout",
        {},
        r"'timeout' ran out of time after 0\.5\d* s \(limit 0\.5 s\) at \d\.\d+ s "
        r"while 'walk' still ran \(at first: walking\)",
    ),
    "two owners": (
        "thieves",
        "conflict",
        {},
        r"'base' is commanded by two nodes at once: 'walk' and 'thief', at \d\.\d+ s",
    ),
    "refused": (
        "refused",
        "refused",
        {"duration": 3.0},
        r"commands were refused from \d\.\d+ s on: the target of 'left_hand' is out of range .*; "
        r"the robot was stopped at .*",
    ),
    "control lost": (
        "walk",
        "control",
        {"at": 3.0, "do": lambda session: end(session, "control"), "duration": 5.0},
        r"control was lost at 3\.\d+ s: the control process ended \(killed by signal 9\)",
    ),
    "disk full": (
        "walk",
        "cut",
        {"at": 3.0, "do": full, "duration": 3.0},
        r"the recording ends at \d\.\d+ s, in the midst of a message: its disk was full, .*",
    ),
}


@pytest.mark.trials
@pytest.mark.parametrize("name", CASES)
def test_the_first_line_says_what_stopped_the_robot(play: Play, name: str) -> None:
    tree, kind, how, headline = CASES[name]
    found = explain(play(tree, mode="realtime", **how))
    assert re.fullmatch(headline, found.headline), found.headline
    assert found.kind == kind


_KILLED = """
import os, signal, sys
from humanoid_bt import Session

with Session("walk", workspace=sys.argv[1], record=sys.argv[2], mode="realtime", camera=False, hold=1.0) as session:
    session.run_until(3.0)
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.trials
def test_decision_that_was_killed_is_told_with_what_control_did(stage: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"
    subprocess.run([sys.executable, "-c", _KILLED, stage, file], capture_output=True, check=False, timeout=60)
    found = explain(file)
    told = re.fullmatch(
        r"the program that runs the tree was killed after its tick of (3\.\d+) s while 'walk' ran; "
        r"control stopped the robot at (3\.\d+) s",
        found.headline,
    )
    assert told, found.headline
    assert 0.05 < float(told[2]) - float(told[1]) < 0.2
    assert (found.kind, found.node) == ("killed", "walk/emergency_stop/walk")


def stalled(length: float, at: list[float]) -> Callable[[Session], None]:
    """Return what keeps control from running for a time [s], and notes since when."""

    def stall(session: Session) -> None:
        at.append(session.state.time)
        control = next(info.processes["control"] for _, info in live_runs() if info.processes["owner"] == os.getpid())
        os.kill(control, signal.SIGSTOP)
        threading.Timer(length, os.kill, (control, signal.SIGCONT)).start()

    return stall


@pytest.mark.trials
def test_control_that_stalls_for_long_ends_the_run_and_is_named(play: Play) -> None:
    since: list[float] = []
    found = explain(play("walk", duration=3.0, mode="realtime", at=1.5, do=stalled(1.3, since)))
    told = re.fullmatch(
        r"control stalled at (\d\.\d+) s: the control process has been silent for more than 1 s", found.headline
    )
    assert told, found.headline
    assert -0.001 < float(told[1]) - since[0] < 0.1  # the headline tells milliseconds
    assert (found.kind, found.node) == ("control", "walk/emergency_stop/walk")
    (stall,) = (told for _, text in found.rows if (told := re.search(r"control stalled for (\d+) ms", text)))
    assert 1200 <= int(stall[1]) < 3000  # a busy machine wakes it late


@pytest.mark.trials
def test_control_that_stalls_for_a_moment_is_told_beside(play: Play) -> None:
    found = explain(play("walk", duration=3.0, mode="realtime", at=1.5, do=stalled(0.2, [])))
    assert found.kind == "unfinished", found
    assert any(name == "warned" and re.search(r"control stalled for [1-9]\d\d ms", text) for name, text in found.rows)
