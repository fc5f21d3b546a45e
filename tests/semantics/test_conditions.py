"""Conditions, expressions, hysteresis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.ticking.executor import NodeError
from tests.semantics.claims import shows
from tests.tree.helpers import Run, load, run, seen


def asked(workspace: Workspace, root: str) -> Run:
    """Load a tree that may ask for percepts outside a watchdog."""
    return Run(load(workspace, f"subtree: true\nroot: {root}\n"))


def answers(under_test: Run, *distances: float) -> str:
    """Tick with the target at these distances; return the root's statuses as letters."""
    letters = []
    for distance in distances:
        under_test.tick(seen(under_test.time, distance))
        letters.append(under_test.executor.status.name[0].lower())
    return "".join(letters)


@shows("condition-at-once")
def test_a_condition_never_runs(workspace: Workspace) -> None:
    for node in ("condition: distance(target) < 1", "within: {percept: target, distance: 1, hysteresis: 0}"):
        assert answers(asked(workspace, f"{{{node}}}"), 0.5, 2, 0.5) == "sfs"


@shows("condition-unseen", "expression-short")
def test_what_was_never_seen_fails(workspace: Workspace) -> None:
    assert asked(workspace, "{condition: distance(target) < 1}").ticks(1) == "f"
    assert asked(workspace, "{condition: not (distance(target) < 1)}").ticks(1) == "f"
    assert asked(workspace, "{condition: not seen(target)}").ticks(1) == "s"
    assert asked(workspace, "{condition: not seen(target) or distance(target) < 1}").ticks(1) == "s"
    assert asked(workspace, "{condition: not (seen(target) and distance(target) < 1)}").ticks(1) == "s"


@shows("condition-untold")
@pytest.mark.parametrize("asks", ["class == 'cup'", "class != 'cup'", "size < 1 m", "yaw < 1 rad", "deviation < 1 m"])
def test_what_nobody_tells_fails(workspace: Workspace, asks: str) -> None:
    under_test = asked(workspace, f'{{condition: "target.{asks}"}}')
    assert answers(under_test, 1.0) == "f"
    assert under_test.tree.root.feedback_message == f"nobody tells the {asks.partition(' ')[0]} of 'target'"


@shows("condition-untold")
def test_what_is_told_is_compared(workspace: Workspace) -> None:
    told = replace(
        seen(0.0)["target"],
        class_name="cup",
        size=np.array([0.1, 0.08, 0.12]),
        orientation=np.array([np.cos(0.2), 0.0, 0.0, np.sin(0.2)]),
        covariance=np.diag([1e-4, 4e-4, 1e-4]),
    )
    for asks in ("class == 'cup'", "size == 12 cm", "yaw > 0.39 and yaw(target) < 0.41", "deviation > 1.9 cm"):
        under_test = asked(workspace, f'{{condition: "target.{asks}"}}')
        under_test.tick({"target": told})
        assert under_test.executor.status.name == "SUCCESS", asks
    other = asked(workspace, "{condition: \"target.class == 'bowl'\"}")
    other.tick({"target": told})
    assert other.executor.status.name == "FAILURE"


@shows("expression-units")
@pytest.mark.parametrize("limit", ["0.5", "0.5 m", "50 cm", "500 mm"])
def test_values_are_in_si_units(workspace: Workspace, limit: str) -> None:
    assert answers(asked(workspace, f"{{condition: distance(target) < {limit}}}"), 0.49, 0.51) == "sf"


@shows("expression-mixed-units")
@pytest.mark.parametrize("text", ["distance(target) < 3 s", "distance(target) + state.time > 1", "state.heading > 1 m"])
def test_units_that_differ_are_refused(workspace: Workspace, text: str) -> None:
    with pytest.raises(UserError, match="cannot be"):
        asked(workspace, f"{{condition: {text}}}")


@shows("expression-division")
def test_a_division_by_zero_is_an_error(workspace: Workspace) -> None:
    with pytest.raises(NodeError, match="ZeroDivisionError"):
        run(workspace, "{condition: 1 / state.time > 0}").tick()


@shows("hysteresis-holds", "hysteresis-begins")
def test_hysteresis(workspace: Workspace) -> None:
    inclusive = asked(workspace, "{condition: distance(target) <= 1 m hysteresis 50 cm}")
    assert answers(inclusive, 1.25, 1.0, 1.25, 1.5, 1.75, 1.25) == "fsssff"
    exclusive = asked(workspace, "{condition: distance(target) < 1 m hysteresis 50 cm}")
    assert answers(exclusive, 1.0, 0.75, 1.25, 1.5, 1.25) == "fssff"
    falling = asked(workspace, "{condition: distance(target) >= 1 m hysteresis 50 cm}")
    assert answers(falling, 0.75, 1.0, 0.5, 0.25, 0.75) == "fssff"


@shows("hysteresis-forgets")
@pytest.mark.parametrize(
    "condition",
    ["condition: distance(target) <= 1 hysteresis 0.5", "within: {percept: target, distance: 1, hysteresis: 0.5}"],
)
def test_hysteresis_is_forgotten_when_the_branch_is_left(workspace: Workspace, condition: str) -> None:
    left = asked(workspace, f"{{reactive_selector: [{{act: {{script: ffsf}}}}, {{{condition}}}]}}")
    assert answers(left, 0.9, 1.25, 1.25, 1.25) == "sssf"  # the third comes from the act


@shows("hysteresis-forgets")
@pytest.mark.parametrize(
    "condition",
    ["condition: distance(target) <= 1 hysteresis 0.5", "within: {percept: target, distance: 1, hysteresis: 0.5}"],
)
def test_it_is_forgotten_when_a_branch_that_ended_is_left_for_another(workspace: Workspace, condition: str) -> None:
    reach = f"{{sequence: [{{{condition}}}, {{act: {{name: reach, script: f}}}}]}}"
    left = asked(workspace, f"{{repeat: {{selector: [{reach}, {{act: {{name: turn, script: rrsr}}}}]}}}}")
    assert answers(left, 0.9, 3, 3, 1.2) == "rrrr"
    assert left.log[-1] == ("start", "turn")
    assert left.log.count(("start", "reach")) == 1


@shows("hysteresis-forgets")
@pytest.mark.parametrize(
    "root",
    [
        "{reactive_sequence: [condition: distance(target) <= 1 hysteresis 0.5, act]}",
        "{reactive_sequence: [{within: {percept: target, distance: 1, hysteresis: 0.5}}, act]}",
        "{switch: {value: distance(target) <= 1 hysteresis 0.5, cases: {true: act}}}",
    ],
)
def test_it_is_forgotten_when_the_branch_is_left_in_the_same_tick(workspace: Workspace, root: str) -> None:
    left = asked(workspace, f"{{running_is_failure: {root}}}")
    assert answers(left, 0.9, 1.25) == "ff"
    assert left.log.count(("start", "act")) == 1


@shows("hysteresis-forgets", "hysteresis-begins")
def test_it_is_forgotten_while_another_part_decides(workspace: Workspace) -> None:
    both = asked(workspace, "{condition: confidence(target) > 0.5 and distance(target) < 1 hysteresis 0.5}")
    for distance, confidence in ((0.9, 0.9), (3, 0.1), (1.2, 0.9)):
        both.tick(seen(both.time, distance, confidence))
    assert both.executor.status.name == "FAILURE"


@shows("hysteresis-forgets", "hysteresis-begins")
def test_it_is_forgotten_while_nobody_tells_what_it_asks(workspace: Workspace) -> None:
    sure = asked(workspace, "{condition: deviation(target) < 0.1 hysteresis 0.05}")
    letters = ""
    for deviation in (0.12, 0.08, 0.12, None, 0.12):
        covariance = None if deviation is None else np.eye(3) * deviation**2
        sure.tick({"target": replace(seen(sure.time)["target"], covariance=covariance)})
        letters += sure.executor.status.name[0].lower()
    assert letters == "fssff"


@shows("hysteresis-forgets")
@pytest.mark.parametrize(
    ("leaf", "came_to"),
    [
        ("set_blackboard: {key: near, expression: NEAR}", lambda left: left.tree.keys[0].value),
        ("log: '{NEAR}'", lambda left: left.events[-1][-1] == "true"),
        (
            "ros_service: {service: /success_0, type: x/A, request: {a: '{NEAR}'}}",
            lambda left: left.calls.asked[-1].request["a"],
        ),
    ],
)
def test_so_is_that_of_what_is_written_told_or_asked(
    workspace: Workspace, leaf: str, came_to: Callable[[Run], bool]
) -> None:
    leaf = leaf.replace("NEAR", "distance(target) <= 1 hysteresis 0.5")
    left = asked(workspace, f"{{reactive_selector: [{{act: {{script: ffsf}}}}, {{sequence: [{{{leaf}}}, act]}}]}}")
    assert answers(left, 0.9, 1.25) == "rr"
    assert came_to(left)
    assert answers(left, 1.25, 1.25) == "sr"
    assert not came_to(left)


@shows("condition-limits")
def test_limits_are_included(workspace: Workspace) -> None:
    assert answers(asked(workspace, "{within: {percept: target, distance: 1}}"), 1.0) == "s"
    assert answers(asked(workspace, "{within: {percept: target, distance: 1}}"), 1.001) == "f"
    for confidence, status in ((0.6, "SUCCESS"), (0.599, "FAILURE")):
        confident = asked(workspace, "{confident: {percept: target, above: 0.6}}")
        confident.tick(seen(0.0, confidence=confidence))
        assert confident.executor.status.name == status


@shows("wait-until")
def test_wait_until_runs_until_it_is_true(workspace: Workspace) -> None:
    wait = asked(workspace, "{wait_until: distance(target) < 1}")
    assert wait.ticks(2) == "rr"
    assert answers(wait, 2, 0.5) == "rs"


@shows("hysteresis-begins")
def test_each_wait_begins_with_nothing_held(workspace: Workspace) -> None:
    twice = asked(workspace, "{repeat: {times: 2, wait_until: distance(target) <= 1 hysteresis 0.5}}")
    assert answers(twice, 0.9, 1.25, 0.9) == "rrs"
