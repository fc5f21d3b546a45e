from __future__ import annotations

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import Run, load, run, seen

NOT_HELD = "its condition does not hold: "


def watched(workspace: Workspace, condition: str) -> Run:
    return run(workspace, f"{{watchdog: {{percept: target, max_age: 99, {condition}}}}}")


def statuses(under_test: Run, *percepts: dict[str, float]) -> str:
    letters = []
    for percept in percepts:
        under_test.tick(seen(under_test.time, **percept))
        letters.append(under_test.executor.status.name[0].lower())
    return "".join(letters)


def test_confident_holds_down_to_its_hysteresis(workspace: Workspace) -> None:
    confident = watched(workspace, "confident: {percept: target, above: 0.6, hysteresis: 0.1}")
    values = (0.59, 0.60, 0.55, 0.50, 0.49, 0.55, 0.61)
    assert statuses(confident, *({"confidence": value} for value in values)) == "fsssffs"


def test_feedback_says_what_was_compared(workspace: Workspace) -> None:
    confident = watched(workspace, "confident: {percept: target, above: 0.6, hysteresis: 0.1}")
    statuses(confident, {"confidence": 0.41})
    assert confident.feedback("confident") == "confidence 0.41 < 0.6"
    statuses(confident, {"confidence": 0.7}, {"confidence": 0.52})
    assert confident.feedback("confident") == "confidence 0.52 >= 0.5"


@pytest.mark.parametrize(
    ("root", "node", "words"),
    [
        ("{condition: x < 9}", "condition", "x {x} < 9"),
        ("{selector: [{condition: seen(target) and x > 3}, success]}", "condition", "x {x} > 3"),
        *(
            (f"{{force_success: {{{kind}: {{condition: x > 9, success: }}}}}}", kind, f"{NOT_HELD}x {{x}} > 9")
            for kind in ("guard", "precondition", "while")
        ),
    ],
)
def test_what_is_compared_is_said_in_every_tick(workspace: Workspace, root: str, node: str, words: str) -> None:
    write = "set_blackboard: {key: x, expression: x + 1}"
    text = f"blackboard: {{x: 0}}\nroot: {{reactive_sequence: [{{{write}}}, {root}, running]}}\n"
    compared = Run(load(workspace, "subtree: true\n" + text))
    said = []
    for _ in range(3):
        compared.tick(seen(compared.time))
        said.append(compared.feedback(node))
    assert said == [words.format(x=x) for x in (1, 2, 3)]


def test_within_holds_out_to_its_hysteresis(workspace: Workspace) -> None:
    within = watched(workspace, "within: {percept: target, distance: 0.5, hysteresis: 0.1}")
    values = (0.51, 0.5, 0.59, 0.61, 0.55)
    assert statuses(within, *({"distance": value} for value in values)) == "fssff"
    assert within.feedback("within") == "distance 0.55 m > 0.5 m"


def test_within_a_bearing_to_either_side(workspace: Workspace) -> None:
    within = watched(
        workspace,
        "within: {percept: target, distance: 2, bearing: 45 deg, bearing_hysteresis: 10 deg}",
    )
    sides = (1.01, 0.99, 1.42, 1.44, -0.99, -1.01)  # beside a target 1 m ahead: tan of the bearing
    assert statuses(within, *({"sideways": side} for side in sides)) == "fssfss"
    statuses(within, {"sideways": 1.5, "distance": 0.01}, {"sideways": 1.5, "distance": 0.01})
    assert within.feedback("within") == "bearing 90 deg beyond 45 deg"


def test_a_branch_that_was_left_starts_with_the_plain_threshold(workspace: Workspace) -> None:
    left = run(
        workspace,
        "{watchdog: {percept: target, max_age: 99, reactive_sequence: [{act: {script: ssfs}}, "
        "{confident: {percept: target, above: 0.6, hysteresis: 0.1}}]}}",
    )
    assert statuses(left, {"confidence": 0.7}, {"confidence": 0.55}, {"confidence": 0.55}, {"confidence": 0.55}) == (
        "ssff"
    )


def test_a_hysteresis_that_would_never_let_go_is_refused(workspace: Workspace) -> None:
    with pytest.raises(UserError, match="must be less than 'above'"):
        watched(workspace, "confident: {percept: target, above: 0.05}")
