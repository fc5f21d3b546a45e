"""Which node the reason of an ended tree is about."""

from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.deciding import deciding, reason_of
from humanoid_bt.tree.ticking.executor import NodeChange
from tests.tree.helpers import run

BAD, GOOD = "{act: {name: bad, script: f}}", "{act: {name: good, script: s}}"
FAILS = "{act: {name: culprit, script: f}}"


@pytest.mark.parametrize(
    ("root", "reason"),
    [
        (f"{{sequence: [{{wait: 0.1 s}}, {{force_success: {BAD}}}, {FAILS}]}}", "culprit failed"),
        (f"{{sequence: [{{selector: [{BAD}, {GOOD}]}}, {FAILS}]}}", "culprit failed"),
        (f"{{selector: [{BAD}, {FAILS}]}}", "culprit failed"),
        (f"{{reactive_selector: [{BAD}, {{act: {{name: it, script: rf}}}}]}}", "it failed"),
        ("{sequence: [{wait: 0.1 s}, {act: {script: rrs}}]}", "act succeeded"),
        (f"{{sequence: [{GOOD}, {{wait: 0.1 s}}]}}", "wait: waited 0.1 s"),
        (
            f"{{sequence: [{{selector: [{BAD}, {FAILS}, {GOOD}]}}, {{act: {{name: last, script: s}}}}]}}",
            "last succeeded",
        ),
        (f"{{inverter: {GOOD}}}", "inverter: its child succeeded"),
        (f"{{sequence: [{{inverter: {BAD}}}, {FAILS}]}}", "culprit failed"),
        (f"{{force_failure: {GOOD}}}", "force_failure: its child succeeded"),
        (f"{{if: {{condition: {BAD}, then: {GOOD}}}}}", "bad failed"),
        (f"{{if: {{condition: {GOOD}, then: {FAILS}}}}}", "culprit failed"),
        (f"{{guard: {{condition: {BAD}, child: {GOOD}}}}}", "bad failed"),
        (f"{{while: {{condition: {BAD}, child: {GOOD}}}}}", "while: its condition does not hold"),
        ("{timeout: {duration: 0.2 s, act: {script: r}}}", "timeout: timed out after 0.2 s (limit 0.2 s)"),
        ("{retry: {attempts: 2, act: {script: frrf}}}", "act failed"),
        (f"{{retry: {{attempts: 3, child: {FAILS}}}}}", "culprit failed"),
        ("{retry: {attempts: 3, condition: state.time < 0 s}}", "retry: attempt 3 of 3 failed"),
        (f"{{min_duration: {{duration: 0.3 s, child: {FAILS}}}}}", "culprit failed"),
        (f"{{parallel: {{children: [{{act: {{script: r}}}}, {FAILS}]}}}}", "culprit failed"),
        (
            f"{{parallel: {{failure: all, children: [{{act: {{name: late, script: rrf}}}}, {FAILS}]}}}}",
            "late failed",
        ),
    ],
)
def test_the_node_that_decided_is_named(workspace: Workspace, root: str, reason: str) -> None:
    tree = run(workspace, root)
    changes: list[NodeChange] = []
    for _ in range(6):
        tree.tick()
        changes += tree.changes
        if tree.executor.status.name != "RUNNING":
            break
    assert reason_of(changes) == reason
    tree.halt()  # as the end of the run does, at the same time
    assert reason_of([*changes, *tree.changes]) == reason


def test_before_the_first_tick_nothing_has_decided() -> None:
    assert deciding([]) is None
    assert reason_of([]) == ""
