from __future__ import annotations

from humanoid_bt.core.messages import Mode
from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import run, seen

STOP = "{emergency_stop: {act: }}"
DOG = "{emergency_stop: {watchdog: {percept: target, max_age: 0.2, on_stale: {idle: {name: wait}}, act: }}}"
STRICT_DOG = "{watchdog: {percept: target, max_age: 0.2, act: }}"


def test_emergency_stop_halts_its_child_and_waits_for_a_reset(workspace: Workspace) -> None:
    stop = run(workspace, STOP)
    stop.tick()
    for _ in range(2):
        stop.tick(mode=Mode.EMERGENCY_STOP, reason="button pressed", source="operator")
        assert stop.executor.status.name == "RUNNING"
    assert stop.feedback("emergency_stop") == "emergency stop: button pressed (from operator); waiting for a reset"
    assert "button pressed" in stop.feedback("act")
    assert stop.log == [("start", "act"), ("INVALID", "act")]
    stop.tick()
    assert stop.log[-1] == ("start", "act")
    assert stop.feedback("emergency_stop") == ""


def test_what_had_ended_is_taken_back_in_a_stop(workspace: Workspace) -> None:
    stop = run(workspace, "{emergency_stop: {act: {script: s}}}")
    stop.tick()
    stop.tick(mode=Mode.EMERGENCY_STOP)
    assert stop.told() == [("act", "INVALID"), ("emergency_stop", "RUNNING")]


def test_a_damped_robot_is_held_too(workspace: Workspace) -> None:
    stop = run(workspace, STOP)
    stop.tick(mode=Mode.DAMP, reason="base tilted")
    assert stop.executor.status.name == "RUNNING"
    assert stop.log == []
    assert stop.feedback("emergency_stop") == "damped: base tilted"


def test_protective_stop_holds_until_the_robot_runs_again(workspace: Workspace) -> None:
    stop = run(workspace, STOP)
    stop.tick()
    for _ in range(2):
        stop.tick(mode=Mode.PROTECTIVE_STOP, reason="decision was silent", source="supervisor")
        assert stop.executor.status.name == "RUNNING"
    assert stop.feedback("emergency_stop") == "held: decision was silent (from supervisor)"
    assert stop.log == [("start", "act"), ("INVALID", "act")]
    stop.tick()
    assert stop.log[-1] == ("start", "act")
    assert stop.feedback("emergency_stop") == ""


def test_watchdog_runs_on_stale_until_the_percept_is_fresh_again(workspace: Workspace) -> None:
    dog = run(workspace, DOG)
    dog.tick(seen(0.0))
    dog.tick()
    dog.tick()  # 0.2 s old: not yet older than its limit
    assert dog.log == [("start", "act")]
    command = dog.tick()
    assert dog.told() == [("act", "INVALID"), ("wait", "RUNNING")]
    assert dog.feedback("watchdog") == "'target' is 0.3 s old (limit 0.2 s)"
    assert set(command.targets) == {"gaze"}
    command = dog.tick(seen(dog.time))
    assert dog.told() == [("wait", "INVALID"), ("act", "RUNNING")]
    assert dog.feedback("wait") == "halted: 'target' is fresh again"
    assert command.targets == {}


def test_a_percept_never_seen_is_stale(workspace: Workspace) -> None:
    dog = run(workspace, STRICT_DOG)
    assert dog.ticks(1) == "f"
    assert dog.feedback("watchdog") == "'target' was never seen"


def test_watchdog_without_on_stale_halts_and_fails(workspace: Workspace) -> None:
    dog = run(workspace, STRICT_DOG)
    dog.tick(seen(0.0))
    assert dog.ticks(3) == "rrf"
    assert dog.log[-1] == ("INVALID", "act")


def test_the_branch_that_runs_is_the_tip(workspace: Workspace) -> None:
    dog = run(workspace, DOG)
    dog.tick(seen(0.0))
    assert dog.tree.root.tip().name == "act"  # type: ignore[union-attr]  # it was ticked
    dog.ticks(3)
    assert dog.tree.root.tip().name == "wait"  # type: ignore[union-attr]  # it was ticked


def test_a_halt_reaches_on_stale(workspace: Workspace) -> None:
    dog = run(workspace, DOG)
    dog.tick()
    dog.changes.clear()
    dog.executor.halt("shutdown")
    assert dog.told() == [("wait", "INVALID"), ("watchdog", "INVALID"), ("emergency_stop", "INVALID")]
