"""What is refused because it would not be safe."""

from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import found, load
from tests.tree.source.test_load import one, problems


def test_a_skill_that_commands_stands_below_an_emergency_stop(workspace: Workspace) -> None:
    message, hint = one(workspace, "root: {inverter: {idle: }}")
    assert message == "2:19 'idle' commands gaze, posture outside an emergency_stop"
    assert "emergency_stop" in hint
    load(workspace, "root: {emergency_stop: {inverter: {idle: }}}")


@pytest.mark.parametrize(
    "reader", ["confident: {percept: ball, above: 1}", "within: {percept: ball, distance: 1}", "reach: {target: ball}"]
)
def test_a_percept_is_used_below_a_watchdog_on_it(workspace: Workspace, reader: str) -> None:
    message, hint = one(workspace, f"root: {{emergency_stop: {{{reader}}}}}")
    assert "uses the percept 'ball' outside a watchdog on it" in message
    assert "percept: ball" in hint
    message, _ = one(workspace, f"root: {{emergency_stop: {{watchdog: {{percept: cup, max_age: 1, {reader}}}}}}}")
    assert "uses the percept 'ball'" in message
    load(workspace, f"root: {{emergency_stop: {{watchdog: {{percept: ball, max_age: 1, {reader}}}}}}}")


def test_a_misspelled_percept_gets_the_one_that_is_watched(workspace: Workspace) -> None:
    _, hint = one(workspace, "root: {emergency_stop: {watchdog: {percept: ball, max_age: 1, reach: {target: bal}}}}")
    assert hint == "did you mean 'ball'? else watchdog: {percept: bal, max_age: 0.5 s, ...}"


def test_on_stale_may_not_use_the_stale_percept(workspace: Workspace) -> None:
    message, _ = one(
        workspace,
        "root: {emergency_stop: {watchdog: {percept: ball, max_age: 1, on_stale: {reach: {target: ball}}, idle: }}}",
    )
    assert "'reach' uses the percept 'ball'" in message


def test_the_percept_is_the_parameters_value(workspace: Workspace) -> None:
    text = (
        "parameters: {x: ball}\n"
        "root: {emergency_stop: {watchdog: {percept: $x, max_age: 1, confident: {percept: ball, above: 1}}}}"
    )
    load(workspace, text)
    message, _ = one(workspace, text, x="cup")
    assert message.startswith("3:")


def test_children_of_a_parallel_do_not_share_resources(workspace: Workspace) -> None:
    message, hint = one(
        workspace,
        "root: {emergency_stop: {watchdog: {percept: p, max_age: 1, parallel: {success: one, children: "
        "[{reach: {target: p}}, act, {inverter: {sequence: [act, look]}}, {sequence: [idle]}]}}}}",
    )
    assert message.endswith("'inverter' and 'sequence' run at once and both command gaze")
    assert "the first is at" in hint


def test_children_that_share_several_resources_are_one_mistake(workspace: Workspace) -> None:
    text = "root: {emergency_stop: {parallel: {success: one, children: [idle, act, {selector: [act, idle]}]}}}"
    assert found(workspace, text) == [
        "2:73 resource-overlap 'idle' and 'selector' run at once and both command gaze and posture"
    ]


def test_branches_of_an_if_do_not_run_at_once(workspace: Workspace) -> None:
    load(workspace, "root: {emergency_stop: {if: {condition: state.standing, then: idle, else: idle}}}")
    decides = "if: {condition: state.standing, then: %s}"
    text = f"root: {{emergency_stop: {{parallel: {{success: one, children: [look, {{{decides}}}]}}}}}}"
    assert found(workspace, text % "idle", "resource-overlap")
    assert not found(workspace, text % "act")


def test_a_skill_tells_which_resources_it_commands_with_its_parameters(workspace: Workspace) -> None:
    text = (
        "root: {emergency_stop: {watchdog: {percept: p, max_age: 1, parallel: "
        "[{reach: {target: p, hand: left}}, {reach: {target: p, hand: %s}}]}}}"
    )
    load(workspace, text % "right")
    assert "both command left_hand" in found(workspace, text % "left")[0]
    assert "both command left_hand" in found(workspace, text % "nearest")[0]


def test_a_parameter_from_the_blackboard_may_be_anything(workspace: Workspace) -> None:
    text = (
        "root: {emergency_stop: {watchdog: {percept: p, max_age: 1, sequence: ["
        "{set_blackboard: {key: side, value: left}}, "
        "{parallel: [{reach: {target: p, hand: left}}, {reach: {target: p, hand: $side}}]}]}}}"
    )
    assert found(workspace, text, "resource-overlap")


@pytest.mark.parametrize(
    ("returned", "error"),
    [
        ("values['nothing']", "KeyError: 'nothing'"),
        ("None", "TypeError: 'NoneType' object is not iterable"),
        ("('gaze')", "ValueError: resources_for returned 'gaze'"),
        ("('gase',)", "ValueError: resources_for returned ('gase',)"),
        ("('gaze', 'base')", "ValueError: resources_for returned ('gaze', 'base')"),
    ],
)
def test_a_skill_that_cannot_tell_what_it_commands_is_answered_with_its_place(
    workspace: Workspace, returned: str, error: str
) -> None:
    (workspace.root / "skills" / "odd.py").write_text(
        "from humanoid_bt.decision.skill import Skill, Status\n"
        "class Odd(Skill):\n"
        "    resources = ('gaze',)\n"
        "    @classmethod\n"
        f"    def resources_for(cls, values): return {returned}\n"
        "    def update(self): return Status.SUCCESS\n"
    )
    assert found(workspace, "root: {emergency_stop: odd}", "broken-skill") == [
        f"2:24 broken-skill 'odd' cannot tell what it commands: {error}"
    ]
    assert found(workspace, "root: odd", "outside-emergency-stop")


def test_percepts_of_expressions_stand_below_a_watchdog(workspace: Workspace) -> None:
    text = "root: {%s: {condition: {expression: distance(cup) < 1 m hysteresis 10 cm}}}"
    assert found(workspace, text % "inverter") == [
        "2:43 outside-watchdog 'condition' uses the percept 'cup' outside a watchdog on it"
    ]
    load(workspace, "root: {watchdog: {percept: cup, max_age: 1, condition: distance(cup) < 1 m}}")


def test_what_stands_below_a_watchdog_with_a_mistake_is_not_blamed(workspace: Workspace) -> None:
    text = "root: {emergency_stop: {watchdog: {percept: 3, max_age: 1, reach: {target: ball}}}}"
    assert len(found(workspace, text)) == 1
    assert not found(workspace, text, "outside-watchdog")


def test_a_node_with_a_mistake_is_checked_all_the_same(workspace: Workspace) -> None:
    codes = [line.split()[1] for line in found(workspace, "root: {sequence: [{idle: {look: 1}}, {idle: {}}]}")]
    assert codes.count("outside-emergency-stop") == 2
    assert "unknown-parameter" in codes
    assert "unreachable" in codes


def test_a_sub_tree_is_told_where_it_is_used_unsafely(workspace: Workspace) -> None:
    (workspace.root / "trees" / "sub.yaml").write_text("format: 1\nsubtree: true\nroot: idle\n")
    problem = problems(workspace, "root: {sequence: [{subtree: sub}, {subtree: sub}]}")[-1]
    assert problem.place is not None and problem.place.file.endswith("sub.yaml")
    assert problem.hint.startswith("emergency_stop: {...} here, or around the sub-tree at ")
    assert problem.hint.endswith("t.yaml:2:20")
