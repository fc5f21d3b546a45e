from __future__ import annotations

import pytest
from py_trees.common import Status

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.forcing import force
from tests.tree.helpers import load, run


@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        ("{force_success: {act: {script: rsf}}}", "rss"),
        ("{force_failure: {act: {script: rsf}}}", "rff"),
        ("{running_is_failure: {act: {script: rsf}}}", "fsf"),
        ("{running_is_success: {act: {script: rsf}}}", "ssf"),
        ("{failure_is_running: {act: {script: rfs}}}", "rrs"),
        ("{success_is_running: {act: {script: rsf}}}", "rrf"),
        ("{once: {act: {script: rsf}}}", "rsss"),
        ("{once: {act: {script: rfs}}}", "rfff"),
        ("{once: {policy: success, act: {script: ffsf}}}", "ffsss"),
        ("{keep_running_until_failure: {act: {script: srsf}}}", "rrrf"),
    ],
)
def test_status_of_a_decorator(workspace: Workspace, root: str, statuses: str) -> None:
    assert run(workspace, root).ticks(len(statuses)) == statuses


@pytest.mark.parametrize(("kind", "end"), [("running_is_failure", "FAILURE"), ("running_is_success", "SUCCESS")])
def test_what_counts_as_ended_is_halted(workspace: Workspace, kind: str, end: str) -> None:
    ended = run(workspace, f"{{emergency_stop: {{{kind}: {{sequence: [{{act: {{script: s}}}}, idle]}}}}}}")
    command = ended.tick()
    assert command.targets == {}
    assert ended.told()[-2:] == [(kind, end), ("emergency_stop", end)]
    assert not any(node.behaviour.status.name == "RUNNING" for node in ended.tree.nodes)
    assert ended.feedback(kind) == "its child runs"
    assert ended.feedback("idle") == f"halted: {kind!r} takes running for {end.lower()}"


def test_once_does_not_run_again(workspace: Workspace) -> None:
    once = run(workspace, "{once: {act: {script: s}}}")
    once.tick()
    once.halt()
    assert once.told() == [("act", "INVALID"), ("once", "INVALID")]
    assert once.ticks(2) == "ss"
    assert once.log == [("start", "act"), ("SUCCESS", "act")]
    assert once.feedback("once") == "succeeded before"


def test_once_starts_again_what_was_halted(workspace: Workspace) -> None:
    once = run(workspace, "{once: {act: {script: rrs}}}")
    once.tick()
    once.halt()
    assert once.ticks(3) == "rss"
    assert once.log == [("start", "act"), ("INVALID", "act"), ("start", "act"), ("SUCCESS", "act")]


def test_status_to_blackboard_writes_every_status(workspace: Workspace) -> None:
    written = run(workspace, "{on_error: {status_to_blackboard: {key: k, act: {script: rsrfrx}}}}")
    key = next(node.values["key"] for node in written.tree.nodes if "key" in node.values)
    assert not key.is_set
    found = []
    for _ in range(6):
        written.tick()
        found.append(key.value)
    assert found == ["running", "success", "running", "failure", "running", "invalid"]


def test_status_to_blackboard_writes_that_it_was_halted_while_it_ran(workspace: Workspace) -> None:
    written = run(workspace, "{status_to_blackboard: {key: k, act: {script: rs}}}")
    key = written.tree.nodes[0].values["key"]
    written.tick()
    written.halt()
    assert key.value == "invalid"
    written.tick()
    written.halt()
    assert key.value == "success"


def test_status_to_blackboard_writes_that_it_was_halted_by_a_result_that_is_forced(workspace: Workspace) -> None:
    written = run(workspace, "{sequence: [{status_to_blackboard: {key: k, act: }}, {log: '{k}'}]}")
    written.tick()
    force(written.tree.nodes[1].behaviour, Status.SUCCESS, "forced")
    assert written.ticks(1) == "s"
    assert [text for _, _, text in written.events] == ["invalid"]


def test_the_status_is_a_text_to_expressions(workspace: Workspace) -> None:
    tree = load(workspace, "root: {parallel: [{status_to_blackboard: {key: k, act: }}, {condition: k == 'running'}]}\n")
    assert not tree.warnings
