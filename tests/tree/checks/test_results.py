"""What the checks know of the decorators and leaves that convert, delay and repeat."""

from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import found

CASES = [
    ("selector: [{force_success: act}, look]", "'force_success' before it never fails"),
    ("sequence: [{force_failure: look}, act]", "'force_failure' before it never succeeds"),
    ("sequence: [{keep_running_until_failure: act}, look]", "before it never succeeds"),
    ("sequence: [{keep_running_until_failure: failure}, look]", "before it always fails"),
    ("sequence: [{keep_running_until_failure: success}, look]", "before it never ends"),
    ("selector: [success, act]", "'success' before it always succeeds"),
    ("sequence: [failure, act]", "'failure' before it always fails"),
    ("selector: [running, act]", "'running' before it never ends"),
    ("selector: [{log: done}, act]", "'log' before it always succeeds"),
    ("selector: [{delay: {duration: 1 s, success: }}, act]", "'delay' before it never fails"),
    ("guard: {condition: 'false', act: }", "'act' is never ticked: its condition always fails"),
    ("selector: [{force_failure: act}, look]", ""),
    ("selector: [{cooldown: {duration: 1 s, success: }}, act]", ""),
    ("selector: [{on_error: success}, act]", ""),
    ("selector: [{for_each: {item: i, items: [1], act: }}, act]", ""),
    ("sequence: [{for_each: {item: i, items: [], failure: }}, act]", ""),
    ("selector: [{switch: {value: state.gait, cases: {stand: success}}}, act]", ""),
    ("sequence: [{while: {condition: state.standing, act: }}, act]", ""),
    ("sequence: [{running_is_success: running}, act]", ""),
    ("selector: [{guard: {condition: state.standing, success: }}, act]", ""),
]


@pytest.mark.parametrize(("root", "message"), CASES)
def test_what_may_get_its_turn(workspace: Workspace, root: str, message: str) -> None:
    told = found(workspace, f"root: {{emergency_stop: {{{root}}}}}", "unreachable")
    assert len(told) == bool(message)
    assert not message or told[0].endswith(message)


@pytest.mark.parametrize(("node", "flaps"), [("guard", True), ("precondition", False), ("while", False)])
def test_which_conditions_may_flap(workspace: Workspace, node: str, flaps: bool) -> None:
    text = f"{{watchdog: {{percept: p, max_age: 1, {node}: {{condition: distance(p) < 1 m, act: }}}}}}"
    assert bool(found(workspace, f"root: {text}", "no-hysteresis")) == flaps
