"""Nodes that ask other programs, answered by name in simulated time."""

from __future__ import annotations

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from tests.semantics.claims import shows
from tests.tree.helpers import Run, found, load, run, seen


def asked(workspace: Workspace, name: str, more: str = "") -> Run:
    """Return a tree of one service, which is answered as its name says."""
    return run(workspace, f"{{ros_service: {{service: /{name}, type: std_srvs/SetBool{more}}}}}")


@shows("ask-once", "ask-runs")
@pytest.mark.parametrize(
    ("name", "statuses"), [("success_0", "ss"), ("failure_200", "rrfrrf"), ("success_100", "rsrs")]
)
def test_it_asks_once_for_each_start_and_answers_as_it_is_answered(
    workspace: Workspace, name: str, statuses: str
) -> None:
    tree = asked(workspace, name)
    assert tree.ticks(len(statuses)) == statuses
    assert len(tree.calls.asked) == len(statuses.replace("r", ""))
    assert not tree.calls.open


@shows("ask-limit")
def test_it_fails_when_its_time_is_over_unless_the_answer_is_there(workspace: Workspace) -> None:
    late = asked(workspace, "success_300", ", timeout: 200 ms")
    assert late.ticks(3) == "rrf"
    assert late.feedback("ros_service") == "not answered within 0.2 s: asked"
    assert not late.calls.open
    assert asked(workspace, "success_200", ", timeout: 200 ms").ticks(3) == "rrs"


@shows("ask-halt")
def test_halted_it_is_done_with_the_call(workspace: Workspace) -> None:
    tree = asked(workspace, "never")
    tree.tick()
    assert len(tree.calls.open) == 1
    tree.halt()
    assert not tree.calls.open


@shows("ask-keys")
def test_what_is_answered_well_is_written_to_keys(workspace: Workspace) -> None:
    leaf = "ros_service: {{service: /{}_0, type: std_srvs/Trigger, response: {{a.b: n}}}}"
    for answer, value in (("success", 5), ("failure", 1)):
        node = leaf.format(answer)
        tree = Run(load(workspace, f"blackboard: {{n: 1}}\nroot: {{sequence: [{{{node}}}, {{condition: n > 0}}]}}\n"))
        tree.tick()
        assert [key.value for key in tree.tree.keys] == [value]


@shows("ask-keys")
def test_if_a_key_refuses_its_value_none_is_written(workspace: Workspace) -> None:
    leaf = "ros_service: {service: /success_0, type: std_srvs/Trigger, response: {a: n, b: word}}"
    board = "n: 1, word: {type: text, default: none}"
    used = "condition: n > 0 and word == 'none'"
    tree = Run(load(workspace, f"blackboard: {{{board}}}\nroot: {{sequence: [{{{leaf}}}, {{{used}}}]}}\n"))
    tree.tick()
    assert tree.feedback("ros_service").startswith("answered, but the key 'word' must be text")
    assert [key.value for key in tree.tree.keys] == [1, "none"]


@shows("ask-fields")
def test_fields_are_values_and_expressions(workspace: Workspace) -> None:
    fields = (
        "{on: $flag, speed: '{3 m/s}', whole: '{count + 1}', text: 'cup {count}', plain: '{{x}}', price: $$5, "
        "nested: {list: [1, '{count}', {deep: '$count'}]}}"
    )
    leaf = f"{{service: /success_0, type: std_srvs/SetBool, request: {fields}}}"
    head = "parameters: {flag: true}\nblackboard: {count: 2}\n"
    tree = Run(load(workspace, f"{head}root: {{ros_service: {leaf}}}\n"))
    tree.tick()
    (call,) = tree.calls.asked
    assert call.request == {
        "on": True,
        "speed": 3,
        "whole": 3,
        "text": "cup 2",
        "plain": "{x}",
        "price": "$5",
        "nested": {"list": [1, 2, {"deep": 2}]},
    }
    again = Run(load(workspace, tree.tree.to_yaml()))
    again.tick()
    assert again.calls.asked == tree.calls.asked


@shows("ask-unseen")
def test_what_asks_about_what_perception_does_not_tell_fails_and_asks_nobody(workspace: Workspace) -> None:
    leaf = "ros_service: {service: /success_0, type: x/A, request: {what: '{target.class}'}}"
    (unwatched,) = found(workspace, f"root: {{{leaf}}}")
    assert "outside-watchdog 'ros_service' uses the percept 'target'" in unwatched
    tree = run(workspace, f"{{watchdog: {{percept: target, max_age: 1 s, {leaf}}}}}")
    tree.tick(seen(0.0))
    assert tree.executor.status.name == "FAILURE"
    assert "class" in tree.feedback("ros_service")
    assert not tree.calls.asked


@shows("ask-nobody")
def test_without_a_gateway_the_tree_is_refused_before_the_run(workspace: Workspace) -> None:
    tree = asked(workspace, "success_0")
    tree.robot.calls = None
    with pytest.raises(UserError) as told:
        tree.executor.setup()
    (problem,) = told.value.problems
    assert problem.code == "no-gateway"
    assert problem.place is not None
    assert problem.place.line == 2
    assert "--gateway" in problem.hint
