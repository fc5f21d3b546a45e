"""Halts: their order, who is told, and why."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.core.messages import Mode
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.executor import NodeError
from tests.semantics.claims import shows
from tests.session.helpers import after, ran
from tests.tree.helpers import Run, run, seen

NESTED = (
    "{reactive_selector: [{inverter: {act: {name: switch, script: sf}}}, {retry: {attempts: 3, sequence: ["
    "{act: {name: done, script: s}}, "
    "{parallel: [{act: {name: left}}, {timeout: {duration: 9, inverter: {act: {name: right}}}}]}, "
    "{act: {name: never}}]}}]}"
)


@pytest.fixture
def preempted(workspace: Workspace) -> Run:
    """A tree in which the switch has just taken over from all the rest."""
    nested = run(workspace, NESTED)
    nested.tick()
    nested.log.clear()
    nested.tick()
    return nested


@shows("halt-order")
def test_children_are_halted_before_their_parents(preempted: Run) -> None:
    halted = [name for name, status in preempted.told() if status == "INVALID"]
    assert halted == ["done", "left", "right", "inverter", "timeout", "parallel", "sequence", "retry"]


@shows("halt-once", "halt-ended", "halt-never-ticked")
def test_only_what_runs_is_told_and_once(preempted: Run) -> None:
    assert [entry for entry in preempted.log if entry[0] == "INVALID"] == [("INVALID", "left"), ("INVALID", "right")]
    assert {node.behaviour.status.name for node in preempted.tree.nodes if node.name in ("done", "never")} == {
        "INVALID"
    }
    preempted.halt()
    assert preempted.log.count(("INVALID", "left")) == preempted.log.count(("INVALID", "right")) == 1


@shows("halt-reason", "halt-recorded", "reason-preempted")
def test_a_skill_knows_why_before_it_is_told(workspace: Workspace) -> None:
    selector = run(workspace, "{reactive_selector: [{act: {script: fsr}}, {act: {name: low}}]}")
    low = next(node.behaviour for node in selector.tree.nodes if node.name == "low")
    reasons: list[str] = []
    low.terminate = lambda _status: reasons.append(vars(low)["halt_reason"])  # type: ignore[method-assign]  # this node alone
    selector.ticks(2)
    assert reasons == ["preempted by 'act', which succeeded"]
    assert selector.changes[1].feedback == f"halted: {reasons[0]}"


def why(under_test: Run) -> str:
    """Return why the node called ``low`` was halted."""
    reason: str = next(vars(node.behaviour)["halt_reason"] for node in under_test.tree.nodes if node.name == "low")
    return reason


@shows("reason-preempted", "reason-parallel", "reason-timeout", "reason-exception")
@pytest.mark.parametrize(
    ("root", "reason"),
    [
        ("{reactive_selector: [{act: {script: fr}}, {act: {name: low}}]}", "preempted by 'act', which runs"),
        ("{reactive_sequence: [{act: {script: sf}}, {act: {name: low}}]}", "preempted by 'act', which failed"),
        ("{parallel: [{act: {script: rf}}, {act: {name: low}}]}", "'parallel' failed"),
        ("{parallel: {success: one, children: [{act: {script: rs}}, {act: {name: low}}]}}", "'parallel' succeeded"),
        ("{timeout: {duration: 100 ms, act: {name: low}}}", "timed out after 0.1 s"),
        (
            "{on_error: {parallel: [{act: {script: rx}}, {act: {name: low}}]}}",
            "'act' raised RuntimeError: out of order",
        ),
    ],
)
def test_reasons_of_nodes(workspace: Workspace, root: str, reason: str) -> None:
    halted = run(workspace, root)
    halted.ticks(2)
    assert why(halted) == reason


@shows("reason-exception")
def test_the_reason_of_an_exception(workspace: Workspace) -> None:
    broken = run(workspace, "{parallel: [{act: {script: x}}, {act: {name: low}}]}")
    with pytest.raises(NodeError):
        broken.tick()
    broken = run(workspace, "{parallel: [{act: {name: low}}, {act: {script: x}}]}")
    with pytest.raises(NodeError):
        broken.tick()
    assert why(broken) == "'act' raised an exception"


@shows("reason-watchdog")
def test_the_reason_of_a_watchdog(workspace: Workspace) -> None:
    dog = run(workspace, "{watchdog: {percept: target, max_age: 0.05, act: {name: low}}}")
    dog.tick(seen(0.0))
    dog.tick()
    assert why(dog) == "'target' is 0.1 s old (limit 0.05 s)"


@shows("reason-stop")
@pytest.mark.parametrize(
    ("mode", "word"), [(Mode.EMERGENCY_STOP, "emergency stop"), (Mode.PROTECTIVE_STOP, "held"), (Mode.DAMP, "damped")]
)
def test_the_reason_of_a_stop(workspace: Workspace, mode: Mode, word: str) -> None:
    stop = run(workspace, "{emergency_stop: {act: {name: low}}}")
    stop.tick()
    stop.tick(mode=mode, reason="smoke", source="a person")
    assert why(stop) == f"{word}: smoke (from a person)"


@shows("halt-raises")
def test_a_node_that_raises_does_not_keep_others(workspace: Workspace) -> None:
    broken = run(workspace, "{parallel: [{act: {name: a}}, bad_end, {act: {name: c}}]}")
    broken.tick()
    broken.log.clear()
    with pytest.raises(NodeError, match="cannot stop"):
        broken.halt()
    assert broken.log == [("INVALID", "a"), ("INVALID", "bad_end"), ("INVALID", "c")]


@shows("halt-at-once")
def test_a_halt_releases_in_its_tick(workspace: Workspace) -> None:
    parallel = run(workspace, "{emergency_stop: {parallel: {success: one, children: [idle, {act: {script: rs}}]}}}")
    assert set(parallel.tick().targets) == {"gaze"}
    assert set(parallel.tick().targets) == set()


@shows("halt-rest", "reason-end")
def test_control_brings_the_robot_to_rest(project: Path) -> None:
    walk = ran("walk", project, interrupted=after(60, "enough"))
    assert walk.told.changes[-2].feedback == "halted: the run ended"
    halted_at = walk.told.changes[-1].time
    assert halted_at + 0.1 < walk.session.engine.clock.now()  # it took its time
    assert walk.settled
