from __future__ import annotations

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes import If, Success
from tests.tree.helpers import Run, load, run, seen

THEN_ELSE = "then: {act: {name: a, script: rrrs}}, else: {act: {name: b, script: rrrs}}"
CASES = "cases: {running: {act: {name: a}}, success: {act: {name: b}}}"


def unwatched(workspace: Workspace, root: str) -> Run:
    """Load a tree that may ask for percepts outside a watchdog."""
    return Run(load(workspace, f"subtree: true\nroot: {root}\n"))


# ---- if ------------------------------------------------------------------------------------------------------------


def test_reactive_if_halts_the_branch_that_no_longer_holds(workspace: Workspace) -> None:
    choice = run(workspace, f"{{reactive_if: {{condition: state.time < 0.15, {THEN_ELSE}}}}}")
    assert choice.ticks(3) == "rrr"
    assert choice.log == [("start", "a"), ("INVALID", "a"), ("start", "b")]
    assert choice.told() == [("condition", "FAILURE"), ("a", "INVALID"), ("b", "RUNNING")]


def test_reactive_if_without_else_fails_and_halts(workspace: Workspace) -> None:
    choice = run(workspace, "{reactive_if: {condition: state.time < 0.15, then: act}}")
    assert choice.ticks(3) == "rrf"
    assert choice.log == [("start", "act"), ("INVALID", "act")]


def test_if_asks_once(workspace: Workspace) -> None:
    choice = run(workspace, f"{{if: {{condition: state.time < 0.15, {THEN_ELSE}}}}}")
    assert choice.ticks(5) == "rrrsr"
    assert choice.log == [("start", "a"), ("SUCCESS", "a"), ("start", "b")]


def test_neither_branch_runs_while_the_condition_runs(workspace: Workspace) -> None:
    choice = run(workspace, f"{{reactive_if: {{condition: {{act: {{name: c, script: srrf}}}}, {THEN_ELSE}}}}}")
    assert choice.ticks(4) == "rrrr"
    assert choice.log[:4] == [("start", "c"), ("SUCCESS", "c"), ("start", "a"), ("start", "c")]
    assert choice.log[4:] == [("INVALID", "a"), ("FAILURE", "c"), ("start", "b")]


def test_if_waits_for_the_answer_of_its_condition(workspace: Workspace) -> None:
    choice = run(workspace, f"{{if: {{condition: {{act: {{name: c, script: rrsf}}}}, {THEN_ELSE}}}}}")
    assert choice.ticks(6) == "rrrrrs"
    assert [name for event, name in choice.log if event == "start"] == ["c", "a"]


def test_a_halted_if_halts_the_branch_that_runs_and_chooses_anew(workspace: Workspace) -> None:
    choice = run(workspace, f"{{if: {{condition: state.time < 0.15, {THEN_ELSE}}}}}")
    choice.ticks(2)
    choice.halt()
    assert choice.told() == [("condition", "INVALID"), ("a", "INVALID"), ("if", "INVALID")]
    choice.tick()
    assert choice.log == [("start", "a"), ("INVALID", "a"), ("start", "b")]


def test_an_error_in_a_condition_halts_the_branch_that_runs(workspace: Workspace) -> None:
    choice = run(
        workspace, "{on_error: {reactive_if: {condition: {act: {name: c, script: sx}}, then: {act: {name: a}}}}}"
    )
    assert choice.ticks(2) == "rf"
    assert choice.told() == [("c", "INVALID"), ("a", "INVALID"), ("reactive_if", "INVALID"), ("on_error", "FAILURE")]


def test_the_tip_of_a_choice_is_what_decided(workspace: Workspace) -> None:
    choice = run(workspace, "{if: {condition: {act: {name: c, script: rf}}, then: act}}")
    choice.tick()
    assert choice.tree.root.tip().name == "c"
    choice.tick()
    assert choice.tree.root.tip().name == "c"


@pytest.mark.parametrize(
    ("memory", "message"), [(True, "leave it out: 'if' goes on"), (False, "use 'reactive_if', which asks again")]
)
def test_memory_is_answered_in_python(memory: bool, message: str) -> None:
    with pytest.raises(TypeError, match=f"If has no parameter 'memory': {message}"):
        If("choice", Success("c"), Success("a"), memory=memory)


# ---- switch --------------------------------------------------------------------------------------------------------


def test_reactive_switch_halts_the_case_that_is_no_longer_chosen(workspace: Workspace) -> None:
    cases = "{'true': {act: {name: a}}, 'false': {act: {name: b}}}"
    switch = run(workspace, f"{{reactive_switch: {{value: state.time < 0.15, cases: {cases}}}}}")
    assert switch.ticks(3) == "rrr"
    assert switch.log == [("start", "a"), ("INVALID", "a"), ("start", "b")]
    assert switch.feedback("a") == "halted: state.time < 0.15 is false"
    assert switch.feedback("reactive_switch") == "state.time < 0.15 is false"


def test_reactive_switch_follows_a_key_within_the_tick(workspace: Workspace) -> None:
    watched = "{failure_is_running: {success_is_running: {status_to_blackboard: {key: k, act: {script: rsf}}}}}"
    cases = "{running: {act: {name: a}}, success: {act: {name: b}}}"
    switch = run(workspace, f"{{parallel: [{watched}, {{reactive_switch: {{value: k, cases: {cases}}}}}]}}")
    assert switch.ticks(3) == "rrf"
    assert [name for event, name in switch.log if event == "start" and name != "act"] == ["a", "b"]
    assert switch.feedback("reactive_switch") == "k is failure: no case"


@pytest.mark.parametrize(
    ("value", "case"),
    [
        ("true", "true"),
        ("1 + 1", "2"),
        ("1 + 1", "2.0"),
        ("-3", "-3"),
        ("50 cm", "0.5"),
        ("0.5 m", "50 cm"),
        ("'left hand'", "left hand"),
        ("'true'", "'true'"),
        ("'1'", "1"),
        ("state.gait", "stand"),
        ("state.mode == 'run'", "true"),
    ],
)
def test_cases_are_compared_as_they_are_written(workspace: Workspace, value: str, case: str) -> None:
    switch = run(workspace, f'{{switch: {{value: "{value}", cases: {{{case}: success}}, default: failure}}}}')
    assert switch.ticks(1) == "s"


@pytest.mark.parametrize(("text", "chosen"), [("1.0", "a"), ("1", "b"), ("500 cm", "c"), ("5 m", "d")])
def test_texts_that_are_the_same_number_are_different_cases(workspace: Workspace, text: str, chosen: str) -> None:
    names = {"1.0": "a", "1": "b", "500 cm": "c", "5 m": "d"}
    cases = ", ".join(f"'{case}': {{act: {{name: {name}}}}}" for case, name in names.items())
    switch = run(workspace, f"{{switch: {{value: \"'{text}'\", cases: {{{cases}}}}}}}")
    switch.tick()
    assert switch.log == [("start", chosen)]


def test_switch_takes_default_or_fails(workspace: Workspace) -> None:
    assert run(workspace, "{switch: {value: \"'x'\", cases: {y: success}, default: running}}").ticks(2) == "rr"
    switch = run(workspace, "{switch: {value: \"'x'\", cases: {y: success}}}")
    assert switch.ticks(1) == "f"
    assert switch.feedback("switch") == "'x' is x: no case"


def test_switch_computes_its_value_once(workspace: Workspace) -> None:
    cases = "cases: {'true': {act: {name: a, script: rrrs}}, 'false': {act: {name: b}}}"
    switch = run(workspace, f"{{switch: {{value: state.time < 0.15, {cases}}}}}")
    assert switch.ticks(5) == "rrrsr"
    assert switch.log == [("start", "a"), ("SUCCESS", "a"), ("start", "b")]
    assert switch.told()[0] == ("a", "INVALID")  # what it came to the last time


def test_a_value_of_an_unseen_percept_fails_the_switch(workspace: Workspace) -> None:
    cases = "cases: {'true': {act: {name: near}}}, default: {act: {name: far}}"
    unseen = unwatched(workspace, f"{{switch: {{value: distance(target) < 1, {cases}}}}}")
    assert unseen.ticks(1) == "f"
    assert unseen.feedback("switch") == "'target' was never seen"
    unseen.tick(seen(0.1, distance=0.5))
    assert unseen.log == [("start", "near")]


def test_hysteresis_of_a_value_begins_anew_when_the_switch_was_left(workspace: Workspace) -> None:
    value = "distance(target) < 1 m hysteresis 0.5 m"
    cases = "cases: {'true': {act: {name: near}}, 'false': {act: {name: far}}}"
    dog = run(workspace, f"{{watchdog: {{percept: target, max_age: 9, switch: {{value: {value}, {cases}}}}}}}")
    dog.tick(seen(0.0, distance=0.9))
    dog.tick(seen(0.1, distance=1.2))
    assert dog.log == [("start", "near")]
    dog.halt()
    dog.tick(seen(0.2, distance=1.2))
    assert dog.log[-1] == ("start", "far")


@pytest.mark.parametrize(
    ("value", "cases", "message"),
    [
        ("state.standing", "{left: success}", "the case 'left' is never chosen: 'state.standing' is true or false"),
        ("state.gait", "{run: success}", "'run' is never chosen: 'state.gait' is 'stand', 'step' or 'settle'"),
        ("state.time", "{'2 m': success}", "the case '2 m' is never chosen: 'state.time' is a number in s"),
        ("1 + 1", "{2: success, 2.0: failure}", "two of its cases are the number 2"),
    ],
)
def test_a_case_that_cannot_be_is_refused(workspace: Workspace, value: str, cases: str, message: str) -> None:
    with pytest.raises(UserError, match=message):
        run(workspace, f"{{switch: {{value: {value}, cases: {cases}}}}}")


@pytest.mark.parametrize(("cases", "kind"), [("{}", "an empty mapping"), ("[success]", "a list")])
def test_cases_are_a_mapping(workspace: Workspace, cases: str, kind: str) -> None:
    with pytest.raises(UserError, match=f"'cases' of 'switch' must be a mapping of values to nodes, not {kind}"):
        run(workspace, f"{{switch: {{value: state.gait, cases: {cases}}}}}")


def test_a_key_without_a_value_is_an_error(workspace: Workspace) -> None:
    choice = "{switch: {value: k, cases: {a: running}}}"
    unset = run(workspace, f"{{on_error: {{sequence: [{choice}, {{set_blackboard: {{key: k, value: a}}}}]}}}}")
    assert unset.ticks(1) == "f"
    assert "read before anything has written it" in unset.feedback("on_error")
