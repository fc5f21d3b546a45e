"""Watchdog and emergency stop."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import pytest

from humanoid_bt.core.messages import Mode
from humanoid_bt.files.workspace import Workspace
from tests.semantics.claims import shows
from tests.session.helpers import ran
from tests.tree.helpers import Run, run, seen

DOG = "{watchdog: {percept: target, max_age: 0.3, on_stale: {act: {name: stale}}, act: {name: fresh}}}"
STOP = "{emergency_stop: {act: {script: rs}}}"


def statuses(under_test: Run, *modes: Mode) -> str:
    """Tick with the robot in these modes; return the root's statuses as letters."""
    letters = []
    for mode in modes:
        under_test.tick(mode=mode, reason="smoke", source="a person")
        letters.append(under_test.executor.status.name[0].lower())
    return "".join(letters)


@shows("watchdog-fresh", "watchdog-stale", "watchdog-again")
def test_watchdog(workspace: Workspace) -> None:
    dog = run(workspace, DOG)
    assert dog.ticks(1) == "r"  # never seen
    assert dog.log == [("start", "stale")]
    dog.tick(seen(0.1))
    assert dog.log[1:] == [("INVALID", "stale"), ("start", "fresh")]
    dog.ticks(3)  # up to an age of 0.3 s
    assert len(dog.log) == 3
    dog.tick()
    assert dog.log[3:] == [("INVALID", "fresh"), ("start", "stale")]
    dog.tick(seen(0.5))
    assert dog.log[5:] == [("INVALID", "stale"), ("start", "fresh")]


@shows("watchdog-stale")
def test_watchdog_without_on_stale_fails(workspace: Workspace) -> None:
    dog = run(workspace, "{watchdog: {percept: target, max_age: 0.3, act: }}")
    dog.tick(seen(0.0))
    assert dog.ticks(4) == "rrrf"
    assert dog.log[-1] == ("INVALID", "act")


@shows("watchdog-age")
def test_age_counts_from_when_it_was_seen(workspace: Workspace) -> None:
    dog = run(workspace, DOG)
    dog.ticks(5)
    dog.tick(seen(0.1))  # arrives at 0.5
    assert dog.log == [("start", "stale")]


@shows("watchdog-confidence")
def test_confidence_does_not_matter(workspace: Workspace) -> None:
    dog = run(workspace, DOG)
    dog.tick(seen(0.0, confidence=0.0))
    assert dog.log == [("start", "fresh")]


@shows("stop-transparent")
def test_emergency_stop_is_transparent(workspace: Workspace) -> None:
    assert statuses(run(workspace, STOP), Mode.RUN, Mode.RUN) == "rs"
    assert statuses(run(workspace, "{emergency_stop: failure}"), Mode.RUN) == "f"


@shows("stop-protective")
def test_protective_stop(workspace: Workspace) -> None:
    stop = run(workspace, STOP)
    assert statuses(stop, Mode.RUN, Mode.PROTECTIVE_STOP, Mode.PROTECTIVE_STOP, Mode.RUN) == "rrrs"
    assert stop.log == [("start", "act"), ("INVALID", "act"), ("start", "act"), ("SUCCESS", "act")]


@shows("stop-latched", "stop-reset")
def test_emergency_stop(workspace: Workspace) -> None:
    stop = run(workspace, STOP)
    assert statuses(stop, Mode.RUN, Mode.EMERGENCY_STOP, Mode.DAMP, Mode.RUN) == "rrrs"
    assert stop.log == [("start", "act"), ("INVALID", "act"), ("start", "act"), ("SUCCESS", "act")]


@shows("stop-same")
@pytest.mark.parametrize("on_estop", ["wait", "end"])
def test_the_run_s_option_does_not_change_the_node(project: Path, on_estop: Literal["wait", "end"]) -> None:
    (project / "trees" / "smoky.yaml").write_text(
        "format: 1\nroot: {emergency_stop: {parallel: [pause, {raise_emergency_stop: {reason: smoke}}]}}\n",
        encoding="utf-8",
    )
    smoky = ran("smoky", project, duration=0.1, on_estop=on_estop)
    changes = [(change.path.removeprefix("smoky/"), change.status.name) for change in smoky.told.changes]
    below = ["pause", "raise_emergency_stop", ""]
    names = [f"emergency_stop/parallel/{name}".rstrip("/") for name in below]
    started = [(name, "RUNNING") for name in [*names, "emergency_stop"]]
    assert changes == [*started, *((name, "INVALID") for name in [*names, "emergency_stop"])]


@shows("stop-raise")
def test_a_node_raises_it_at_once(workspace: Workspace) -> None:
    raised = run(workspace, "{sequence: [{parallel: [{raise_emergency_stop: {reason: smoke}}, failure]}]}")
    told: list[tuple[str, str]] = []
    vars(raised.robot)["_raise_estop"] = lambda source, reason: told.append((source, reason))
    assert raised.ticks(1) == "f"
    assert told == [("t/sequence/parallel/raise_emergency_stop", "smoke")]


@shows("stop-silent")
def test_servo_and_supervisor_go_on_while_no_command_comes(project: Path) -> None:
    engine = ran("wait", project).session.engine
    engine.supervisor.stops.clear()
    since = engine.clock.now()
    modes = []
    for _ in range(10):  # 20 ms each
        engine.advance()
        modes.append(engine.sense()[0].mode)
    assert modes[:4] == [Mode.RUN] * 4
    assert modes[5:] == [Mode.PROTECTIVE_STOP] * 5
    assert engine.clock.now() == pytest.approx(since + 0.2)
    assert engine.sense()[0].base_settled


@shows("stop-supervisor")
def test_the_supervisor_stops_the_robot_without_the_tree(project: Path) -> None:
    (project / "trees" / "blind.yaml").write_text(
        "format: 1\nroot: {sequence: [{wait: 100 ms}, {raise_emergency_stop: {reason: smoke}}]}\n", encoding="utf-8"
    )
    blind = ran("blind", project, duration=0.5)
    assert blind.session.engine.sense()[0].mode is Mode.EMERGENCY_STOP
