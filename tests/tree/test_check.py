"""What is refused because it would not be safe."""

from __future__ import annotations

import pytest

from humanoid_bt.workspace import Workspace
from tests.tree.helpers import load
from tests.tree.test_load import one


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
        "root: {emergency_stop: {watchdog: {percept: p, max_age: 1, parallel: "
        "[{reach: {target: p}}, act, {inverter: {approach: {target: p}}}, {sequence: [idle]}]}}}",
    )
    assert message.endswith("'inverter' and 'sequence' run at once and both command gaze")
    assert "the first is at" in hint
