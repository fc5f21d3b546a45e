"""What starts again after its end where a tree asks again in every tick."""

from __future__ import annotations

import pytest

from humanoid_bt.checking.check import checked
from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import found, load, write

WALK, REACH = "{approach: {target: p}}", "{reach: {target: p}}"
HELD = "{condition: distance(p) < 1 m hysteresis 5 cm}"


def told(workspace: Workspace, root: str) -> list[str]:
    """Return what starts again below an emergency stop and a watchdog, without its place."""
    text = f"root: {{emergency_stop: {{watchdog: {{percept: p, max_age: 1, {root}}}}}}}"
    return [message.split("starts-again ")[1] for message in found(workspace, text, "starts-again")]


SEQUENCE = [
    (WALK, "approach"),
    ("{timeout: {duration: 9 s, approach: {target: p}}}", "timeout"),
    ("plain", "plain"),
    ("{wait: 1 s}", "wait"),
    ("{inverter: {inverter: act}}", "inverter"),
    ("{raise_emergency_stop: {reason: x}}", "raise_emergency_stop"),
    ("{delay: {duration: 1 s, success: }}", "delay"),
    ("{min_duration: {duration: 1 s, success: }}", "min_duration"),
    ("{cooldown: {duration: 1 s, act: }}", "cooldown"),
    (f"{{sequence: [{HELD}, act]}}", "sequence"),
    (f"{{reactive_sequence: [{HELD}, act]}}", "reactive_sequence"),
    (f"{{selector: [act, {HELD}]}}", "selector"),
    (f"{{selector: [failure, act, {HELD}]}}", "selector"),
    ("{if: {condition: distance(p) < 1, then: act}}", "if"),
    ("{if: {condition: {act: }, then: success}}", "if"),
    ("{switch: {value: state.gait, cases: {stand: act}}}", "switch"),
    ("{guard: {condition: distance(p) < 1 m hysteresis 5 cm, act: }}", "guard"),
    ("{precondition: {condition: distance(p) < 1, act: }}", "precondition"),
    ("{while: {condition: {act: }, success: }}", "while"),
    ("{repeat: {times: 3, condition: seen(p)}}", "repeat"),
    ("{for_each: {item: n, items: [1, 2], success: }}", "for_each"),
    ("{retry: {attempts: 3, act: }}", "retry"),
    ("{on_error: act}", "on_error"),
    ("{emergency_stop: act}", "emergency_stop"),
    ("{parallel: [act, {wait_until: seen(p)}]}", "parallel"),
    ("{parallel: {success: one, children: [act, {wait_until: seen(p)}]}}", "parallel"),
    ("{status_to_blackboard: {key: k, act: }}", "status_to_blackboard"),
    ("{failure_is_running: act}", "failure_is_running"),
]


@pytest.mark.parametrize(("child", "name"), SEQUENCE)
def test_what_succeeds_only_by_running_starts_again_in_a_reactive_sequence(
    workspace: Workspace, child: str, name: str
) -> None:
    message = f"{name!r} starts again when it has succeeded, and halts 'reach' behind it"
    assert told(workspace, f"reactive_sequence: [{child}, {REACH}]") == [message]
    assert told(workspace, f"reactive_sequence: [{HELD}, {child}, success, {REACH}]") == [message]


@pytest.mark.parametrize(
    "child",
    [
        HELD,
        "{wait_until: seen(p)}",
        "{once: act}",
        "{once: {policy: success, act: }}",
        f"{{selector: [{HELD}, {WALK}]}}",
        f"{{reactive_selector: [{HELD}, {WALK}]}}",
        f"{{selector: [{{inverter: {HELD}}}, act, look]}}",
        f"{{sequence: [{HELD}, {{wait_until: seen(p)}}]}}",
        "{inverter: {sequence: [{condition: seen(p)}, act]}}",
        "{force_success: {sequence: [{condition: seen(p)}, act]}}",
        "{timeout: {duration: 1 s, wait_until: seen(p)}}",
        "{if: {condition: distance(p) < 1, then: success, else: act}}",
        "{switch: {value: state.gait, cases: {stand: success, step: act}}}",
        "{guard: {condition: seen(p), wait_until: seen(p)}}",
        "{while: {condition: seen(p), act: }}",
        "{retry: {attempts: 3, condition: seen(p)}}",
        "{repeat: {times: 1, wait_until: seen(p)}}",
        "{for_each: {item: n, items: [1], wait_until: seen(p)}}",
        "{parallel: [{wait_until: seen(p)}, {wait_until: seen(p)}]}",
        "{running_is_success: act}",
        "{watchdog: {percept: p, max_age: 1 s, on_stale: success, act: }}",
        "{status_to_blackboard: {key: k, wait_until: seen(p)}}",
        "{log: hi}",
    ],
)
def test_what_can_succeed_at_once_is_left_alone(workspace: Workspace, child: str) -> None:
    assert told(workspace, f"reactive_sequence: [{child}, {REACH}]") == []


@pytest.mark.parametrize(
    ("child", "name"),
    [
        (REACH, "reach"),
        (f"{{sequence: [{{wait: 1 s}}, {HELD}]}}", "sequence"),
        (f"{{retry: {{attempts: 3, {HELD[1:-1]}}}}}", "retry"),
        ("{on_error: {sequence: [act, failure]}}", "on_error"),
        ("{once: {policy: success, act: }}", "once"),
        ("{switch: {value: state.gait, cases: {stand: act}, default: act}}", "switch"),
    ],
)
def test_what_fails_only_by_running_starts_again_in_a_reactive_selector(
    workspace: Workspace, child: str, name: str
) -> None:
    message = f"{name!r} starts again when it has failed, and halts 'idle' behind it"
    assert told(workspace, f"reactive_selector: [{child}, {{idle: }}]") == [message]


@pytest.mark.parametrize(
    "child",
    [
        f"{{reactive_sequence: [{HELD}, {REACH}]}}",
        f"{{sequence: [{HELD}, {REACH}]}}",
        "{guard: {condition: distance(p) < 1 m hysteresis 5 cm, reach: {target: p}}}",
        "{precondition: {condition: distance(p) < 1 m, reach: {target: p}}}",
        "{cooldown: {duration: 9 s, act: }}",
        "{success_is_running: {cooldown: {duration: 9 s, act: }}}",
        "{watchdog: {percept: p, max_age: 1 s, act: }}",
        "{if: {condition: seen(p), then: act}}",
        "{switch: {value: state.gait, cases: {stand: act}}}",
        "{once: act}",
        "{repeat: {times: 3, condition: seen(p)}}",
        "{keep_running_until_failure: {sequence: [{condition: seen(p)}, act]}}",
        "{for_each: {item: n, items: [1], sequence: [{condition: seen(p)}, act]}}",
        "{while: {condition: seen(p), sequence: [{condition: seen(p)}, act]}}",
    ],
)
def test_what_can_fail_at_once_is_left_alone(workspace: Workspace, child: str) -> None:
    assert told(workspace, f"reactive_selector: [{child}, idle]") == []


@pytest.mark.parametrize(
    "root",
    [
        f"sequence: [{WALK}, {REACH}]",
        f"selector: [{WALK}, {REACH}]",
        f"parallel: [{REACH}, act]",
        f"reactive_sequence: [{WALK}, {HELD}]",
        f"reactive_sequence: [{WALK}, {HELD}, {{log: there}}]",
        f"reactive_sequence: [{HELD}, {WALK}]",
        f"reactive_selector: [{WALK}, success]",
        f"reactive_selector: [{{force_success: {WALK}}}, {REACH}]",
        f"reactive_sequence: [idle, {WALK}, {REACH}]",
    ],
)
def test_what_halts_nothing_that_runs_is_left_alone(workspace: Workspace, root: str) -> None:
    assert told(workspace, root) == []


def test_each_child_is_told_with_the_next_that_runs(workspace: Workspace) -> None:
    root = f"reactive_sequence: [{WALK}, {{log: there}}, {REACH}, success, act]"
    assert told(workspace, root) == [
        "'approach' starts again when it has succeeded, and halts 'reach' behind it",
        "'reach' starts again when it has succeeded, and halts 'act' behind it",
    ]


@pytest.mark.parametrize("root", ["reactive_sequence: [fetch, act]", "fallback: [{reactive_fallback: [fetch, act]}]"])
def test_it_looks_through_sub_trees_in_both_directions(workspace: Workspace, root: str) -> None:
    inner = "subtree: true\nparameters: {do: {type: node, doc: What.}}\nroot: {timeout: {duration: 9 s, $do: }}"
    write(workspace, "inner", inner)
    used = root.replace("fetch", "{subtree: {tree: inner, name: part, do: act}}")
    assert len(told(workspace, used)) == 1
    write(workspace, "inner", inner.replace("timeout: {duration: 9 s, $do: }", f"{root.replace('fetch', '$do')}"))
    (only,) = told(workspace, "subtree: {tree: inner, do: act}")
    assert only.startswith("'act' starts again when it has ")


def test_it_is_found_once_in_a_sub_tree_that_is_used_twice(workspace: Workspace) -> None:
    write(workspace, "inner", "subtree: true\nroot: {reactive_sequence: [act, plain]}")
    assert len(told(workspace, "sequence: [{subtree: inner}, {subtree: inner}]")) == 1


@pytest.mark.parametrize(
    ("root", "message"),
    [
        (
            f"reactive_if: {{condition: {{act: }}, then: {WALK}}}",
            "'act' starts again when it has succeeded, and halts 'approach'",
        ),
        (
            f"reactive_if: {{condition: {{act: }}, then: success, else: {WALK}}}",
            "'act' starts again when it has failed, and halts 'approach'",
        ),
        (
            f"guard: {{condition: {{act: }}, {WALK[1:-1]}}}",
            "'act' starts again when it has succeeded, and halts 'approach'",
        ),
        (f"if: {{condition: {{act: }}, then: {WALK}}}", ""),
        (f"precondition: {{condition: {{act: }}, {WALK[1:-1]}}}", ""),
        ("reactive_if: {condition: {act: }, then: success}", ""),
        (f"reactive_if: {{condition: {{wait: 1 s}}, then: success, else: {WALK}}}", ""),
        (f"reactive_if: {{condition: {{wait_until: seen(p)}}, then: {WALK}}}", ""),
        (f"guard: {{condition: {{selector: [{HELD}, act]}}, {WALK[1:-1]}}}", ""),
        (f"guard: {{condition: {HELD}, {WALK[1:-1]}}}", ""),
    ],
)
def test_so_do_conditions_that_run(workspace: Workspace, root: str, message: str) -> None:
    assert told(workspace, root) == ([message] if message else [])


def hints(workspace: Workspace, root: str) -> list[str]:
    warnings = load(workspace, f"root: {{{root}}}").warnings
    return [warning.hint for warning in warnings if warning.code == "starts-again"]


def test_the_hint_is_the_type_to_use_instead(workspace: Workspace) -> None:
    once = "or put 'timeout' below 'once' if it is to run only once"
    walk = "{timeout: {duration: 1 s, act: }}"
    assert hints(workspace, f"reactive_sequence: [{walk}, act]") == [
        f"use 'sequence' instead of 'reactive_sequence': it goes on with what runs; {once}"
    ]
    assert hints(workspace, f"reactive_fallback: [{{condition: 1 < state.time / 1 s}}, {walk}, act]") == [
        f"put 'timeout' and what is behind it into a 'selector': it goes on with what runs; {once}"
    ]
    for kind, instead in (("reactive_if", "if"), ("guard", "precondition")):
        runs = "then: act" if kind == "reactive_if" else "act:"
        (hint,) = hints(workspace, f"{kind}: {{condition: {walk}, {runs}}}")
        assert hint.startswith(f"use {instead!r} instead of {kind!r}: it goes on with what runs")


def test_the_place_is_the_childs_and_a_comment_allows_it(workspace: Workspace) -> None:
    text = "root:\n  reactive_sequence:\n    - act\n    - plain\n"
    assert found(workspace, text) == [
        "4:7 starts-again 'act' starts again when it has succeeded, and halts 'plain' behind it"
    ]
    path = write(workspace, "allowed", text.replace("- act", "- act  # allow starts-again: it is quick"))
    assert checked(path, workspace) == []


def test_a_skill_can_say_that_it_answers_at_once(workspace: Workspace) -> None:
    (hint,) = hints(workspace, "reactive_sequence: [act, plain]")
    assert hint.endswith("or, in its class, runs = False if it always answers at once")
    (hint,) = hints(workspace, "emergency_stop: {reactive_sequence: [look, act]}")
    assert "runs = False" not in hint, "what commands the robot takes its time"
    file = workspace.root / "skills" / "test_skills.py"
    asks = "class Powered(Skill):\n    runs = False\n    def update(self):\n        return self.succeed('')\n"
    file.write_text(file.read_text() + asks)
    assert not hints(workspace, "reactive_sequence: [powered, act]")
    assert found(workspace, "root: {timeout: {duration: 1 s, powered: }}", "no-effect")


@pytest.mark.parametrize("child", ["{timeout: {duration: 1 m, act: }}", "{timeout: {duration: 1 s, acd: }}", "acd"])
def test_what_has_a_mistake_is_told_for_that_alone(workspace: Workspace, child: str) -> None:
    assert found(workspace, f"root: {{reactive_sequence: [{child}, act]}}", "starts-again") == []


def test_children_of_one_name_are_told_apart_as_in_their_paths(workspace: Workspace) -> None:
    message = "'wait' starts again when it has succeeded, and halts 'wait#2' behind it"
    assert told(workspace, "reactive_sequence: [{wait: 1 s}, {wait: 2 s}]") == [message]
