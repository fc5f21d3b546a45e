"""Nodes that never get their turn, and nodes that change nothing."""

from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import found, load

NEVER = [
    ("selector: [idle, act]", "'act' is never ticked: 'idle' before it never ends"),
    ("sequence: [idle, act]", "'act' is never ticked: 'idle' before it never ends"),
    ("fallback: [act, idle, act, look]", "'act' is never ticked, nor 1 more behind it: 'idle' before it never ends"),
    ("reactive_selector: [idle, act]", "'act' is never ticked: 'idle' before it never ends"),
    ("reactive_sequence: [failure, act]", "'act' is never ticked: 'failure' before it always fails"),
    ("selector: [{wait: 1 s}, act]", "'wait' before it never fails"),
    ("selector: [{set_blackboard: {key: k, value: 1}}, act]", "'set_blackboard' before it always succeeds"),
    ("selector: [{condition: 1 < 2}, act]", "'condition' before it always succeeds"),
    ("selector: [{emergency_stop: idle}, act]", "'emergency_stop' before it never ends"),
    ("sequence: [{condition: not true}, act]", "'condition' before it always fails"),
    ("sequence: [{inverter: {wait: 1 s}}, act]", "'inverter' before it never succeeds"),
    ("sequence: [{repeat: act}, act]", "'repeat' before it never succeeds"),
    ("selector: [{retry: {attempts: -1, act: }}, act]", "'retry' before it never fails"),
    ("selector: [{sequence: [{wait: 1 s}, {wait: 1 s}]}, act]", "'sequence' before it never fails"),
    ("selector: [{parallel: [{wait: 1}, {wait: 2}]}, act]", "'parallel' before it never fails"),
    ("selector: [{if: {condition: state.standing, then: {wait: 1}, else: idle}}, act]", "'if' before it never fails"),
    ("if: {condition: 'true', then: act, else: look}", "'else' of 'if' is never ticked: its condition always succeeds"),
    ("if: {condition: 'false', then: act, else: look}", "'then' of 'if' is never ticked: its condition always fails"),
    (
        "reactive_if: {condition: 'true', then: act, else: look}",
        "'else' of 'reactive_if' is never ticked: its condition always succeeds",
    ),
    ("if: {condition: {inverter: idle}, then: act}", "'then' of 'if' is never ticked: its condition never ends"),
]


@pytest.mark.parametrize(("root", "message"), NEVER)
def test_what_never_gets_its_turn_is_told(workspace: Workspace, root: str, message: str) -> None:
    told = found(workspace, f"root: {{emergency_stop: {{{root}}}}}", "unreachable")
    assert len(told) == 1
    assert told[0].endswith(message)


@pytest.mark.parametrize(
    "root",
    [
        "selector: [act, {condition: state.standing}, idle]",
        "sequence: [act, {wait: 1 s}, {set_blackboard: {key: k, value: 1}}, {clear_blackboard: k}, look, idle]",
        "selector: [{timeout: {duration: 1 s, idle: }}, act]",
        "selector: [{emergency_stop: act}, act]",
        "selector: [{watchdog: {percept: p, max_age: 1, idle: }}, act]",
        "selector: [{repeat: act}, act]",
        "sequence: [{repeat: {times: 2, act: }}, act]",
        "sequence: [{retry: {attempts: -1, act: }}, act]",
        "selector: [{inverter: {wait: 1 s}}, act]",
        "selector: [{set_blackboard: {key: k, expression: distance(p)}}, act]",
        "sequence: [{for_each: {item: i, items: [1], act: }}, act]",
        "sequence: [{parallel: {success: one, children: [idle, act]}}, act]",
        "selector: [{parallel: [idle, act]}, act]",
        "selector: [{if: {condition: state.standing, then: {wait: 1}}}, act]",
        "sequence: [{if: {condition: state.standing, then: idle, else: act}}, act]",
        "sequence: [{condition: 1 / 0 < 2}, act]",
        "selector: [plain, act]",
    ],
)
def test_what_may_get_its_turn_is_left_alone(workspace: Workspace, root: str) -> None:
    assert not found(workspace, f"root: {{emergency_stop: {{{root}}}}}", "unreachable")


def test_a_parameter_may_have_another_value_in_the_next_run(workspace: Workspace) -> None:
    load(workspace, "parameters: {fast: true}\nroot: {if: {condition: $fast, then: act, else: plain}}")
    assert not found(workspace, "parameters: {fast: true}\nroot: {if: {condition: $fast, then: act, else: plain}}")


def test_the_first_of_them_is_the_place_and_the_cause_is_named(workspace: Workspace) -> None:
    (warning,) = load(workspace, "root:\n  emergency_stop:\n    selector:\n      - idle\n      - act\n").warnings
    assert (warning.place.line, warning.place.column) == (6, 9) if warning.place else False
    assert warning.hint.endswith("t.yaml:5:9")


def test_a_sub_tree_answers_what_its_root_answers(workspace: Workspace) -> None:
    (workspace.root / "trees" / "sub.yaml").write_text("format: 1\nsubtree: true\nroot: {selector: [act, idle]}\n")
    assert not found(workspace, "root: {emergency_stop: {sequence: [{subtree: sub}, act]}}")
    assert found(workspace, "root: {emergency_stop: {selector: [{subtree: sub}, act]}}") == [
        "2:52 unreachable 'act' is never ticked: 'subtree' before it never fails"
    ]


def test_a_child_that_is_not_known_may_answer_anything(workspace: Workspace) -> None:
    assert not found(workspace, "root: {selector: [{sequence: [{wait: 1}, {inverter: idel}]}, act]}", "unreachable")
    assert not found(workspace, "root: {selector: [{sequence: [{wait: 1}, idel]}, act]}", "unreachable")


NO_EFFECT = [
    ("retry: {attempts: 3, wait: 1 s}", "'retry' has no effect: 'wait' never fails, so nothing is ever tried again"),
    ("repeat: {times: 3, idle: }", "'repeat' has no effect: 'idle' never ends, so nothing is ever repeated"),
    ("timeout: {duration: 3, condition: state.standing}", "'timeout' has no effect: 'condition' answers at once, "),
]


@pytest.mark.parametrize(("root", "message"), NO_EFFECT)
def test_a_decorator_with_nothing_to_do_is_told(workspace: Workspace, root: str, message: str) -> None:
    (told,) = found(workspace, f"root: {{emergency_stop: {{{root}}}}}")
    assert told.startswith(f"2:25 no-effect {message}")


@pytest.mark.parametrize(
    "root",
    [
        "retry: {attempts: 3, act: }",
        "retry: {attempts: 1, act: }",
        "repeat: {times: 3, wait: 1 s}",
        "repeat: {set_blackboard: {key: k, value: 1}}",
        "timeout: {duration: 3, idle: }",
    ],
)
def test_a_decorator_with_something_to_do_is_left_alone(workspace: Workspace, root: str) -> None:
    assert not found(workspace, f"root: {{emergency_stop: {{{root}}}}}")


def test_a_parallel_of_which_too_few_can_succeed_is_told(workspace: Workspace) -> None:
    assert found(workspace, "root: {emergency_stop: {parallel: [idle, act]}}") == [
        "2:25 never-succeeds 'parallel' never succeeds: it needs 2 children that do, and only 1 can"
    ]
    text = "root: {emergency_stop: {parallel: {success: 2, children: [idle, act, act]}}}"
    assert not found(workspace, text)
    text = "root: {emergency_stop: {parallel: [idle, {repeat: act}]}}"
    assert not found(workspace, text), "it is made to run on"
