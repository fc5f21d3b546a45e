"""What stopped a robot on the wall clock."""

from __future__ import annotations

import os
import re
import signal
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.link.run_folder import live_runs
from humanoid_bt.review.explain import explain
from humanoid_bt.session.session import Session

pytestmark = pytest.mark.realtime


def test_a_tick_that_takes_too_long_is_named_with_its_line(play: Callable[..., Path]) -> None:
    found = explain(play("sleepy", duration=0.7, mode="realtime"))
    headline = r"one tick took 0\.[5-9]\d s at ([\d.]+) s in 'sleepy', skills/staged\.py:\d+: "
    told = re.match(headline + r"the robot was stopped at ([\d.]+) s", found.headline)
    assert told, found.headline
    assert found.kind == "slow_tick"
    assert found.node == "sleepy/emergency_stop/sleepy"
    assert 0.05 < float(told[2]) - float(told[1]) < 0.2


def stalled(length: float, at: list[float]) -> Callable[[Session], None]:
    """Return what keeps control from running for a time [s], and notes since when."""

    def stall(session: Session) -> None:
        at.append(session.state.time)
        control = next(info.processes["control"] for _, info in live_runs() if info.processes["owner"] == os.getpid())
        os.kill(control, signal.SIGSTOP)
        threading.Timer(length, os.kill, (control, signal.SIGCONT)).start()

    return stall


@pytest.mark.trials
def test_control_that_stalls_for_long_ends_the_run_and_is_named(play: Callable[..., Path]) -> None:
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
def test_control_that_stalls_for_a_moment_is_told_beside(play: Callable[..., Path]) -> None:
    found = explain(play("walk", duration=3.0, mode="realtime", at=1.5, do=stalled(0.2, [])))
    assert found.kind == "unfinished"
    assert any(name == "warned" and re.search(r"control stalled for [1-9]\d\d ms", text) for name, text in found.rows)
