"""What the supervisor makes of a pause: it holds the robot, and everything outranks it."""

from __future__ import annotations

import pytest

from humanoid_bt.core.messages import Mode, Pause
from tests.control.supervised import HAND, Run, lying


@pytest.fixture
def run() -> Run:
    return Run()


PAUSE = Pause("keyboard", "a key was pressed")


def test_a_pause_holds_the_robot_until_a_command_without_one(run: Run) -> None:
    run.send(pause=PAUSE)
    run.go()
    assert (run.mode, run.supervisor.reason, run.supervisor.source) == (Mode.PAUSED, PAUSE.reason, PAUSE.source)
    assert run.supervisor.hold
    assert run.supervisor.targets == {}
    run.send()
    run.go()
    assert (run.mode, run.supervisor.reason) == (Mode.RUN, "")
    assert run.supervisor.targets == HAND
    assert run.supervisor.stops == []


def test_silence_and_a_fault_outrank_a_pause(run: Run) -> None:
    run.send(pause=PAUSE)
    run.go(100)
    assert run.mode is Mode.PAUSED
    run.go()
    assert run.mode is Mode.PROTECTIVE_STOP
    run.send(pause=PAUSE)
    run.go()
    assert run.mode is Mode.PAUSED
    for _ in range(201):
        run.send(pause=PAUSE)
        run.go(fault="no solution")
    assert run.mode is Mode.PROTECTIVE_STOP
    run.send(pause=PAUSE)
    run.go()
    assert run.mode is Mode.PAUSED
    run.supervisor.request_stop("the tree", "it raised")
    run.go()
    assert (run.mode, run.supervisor.reason) == (Mode.PROTECTIVE_STOP, "it raised")


def test_a_stop_of_a_paused_robot_stays_until_its_reset(run: Run) -> None:
    run.send(pause=PAUSE)
    run.go()
    run.supervisor.raise_estop("test", "pressed")
    run.go()
    run.send(pause=PAUSE)
    run.go()
    assert run.mode is Mode.EMERGENCY_STOP
    assert run.supervisor.reset() == ""
    run.go()
    assert run.mode is Mode.RUN
    run.send(pause=PAUSE)
    run.go(estimate=lying())
    assert run.mode is Mode.DAMP


def test_a_stall_of_control_is_forgiven_in_a_pause_too(run: Run) -> None:
    run.send(pause=PAUSE)
    run.go(90)
    run.supervisor.forgive_silence()
    run.go(90)
    assert run.mode is Mode.PAUSED


def test_what_is_no_pause_is_refused(run: Run) -> None:
    assert not run.send(pause="please")  # type: ignore[arg-type]  # the mistake that is tried
    assert "'please' is no pause" in run.supervisor.rejected[0]
