"""Thresholds that make a robot flap, and skills that it may wait for for ever."""

from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import found, load

NEAR = "condition: distance(p) < 1 m"


def below(root: str) -> str:
    return f"root: {{emergency_stop: {{watchdog: {{percept: p, max_age: 1, {root}}}}}}}"


@pytest.mark.parametrize(
    "root",
    [
        f"reactive_sequence: [{{{NEAR}}}, act]",
        f"reactive_selector: [{{{NEAR}}}, act]",
        f"reactive_selector: [{{reactive_sequence: [{{{NEAR}}}, look]}}, idle]",
        f"reactive_selector: [{{sequence: [{{set_blackboard: {{key: k, value: 1}}}}, {{{NEAR}}}]}}, idle]",
        f"reactive_selector: [{{inverter: {{{NEAR}}}}}, idle]",
        f"reactive_sequence: [{{selector: [act, {{{NEAR}}}]}}, act]",
        "reactive_if: {condition: distance(p) < 1 m, then: act}",
        "reactive_if: {condition: 1 > distance(p), then: look, else: act}",
        "reactive_switch: {value: distance(p) < 1 m, cases: {'true': act}}",
        "reactive_sequence: [{condition: state.standing and distance(p) < 1 m}, act]",
        "reactive_sequence: [{confident: {percept: p, above: 0.6, hysteresis: 0}}, act]",
        "reactive_sequence: [{within: {percept: p, distance: 1, hysteresis: 0 cm}}, act]",
        "reactive_sequence: [{within: {percept: p, distance: 1, bearing: 1, bearing_hysteresis: 0}}, act]",
    ],
)
def test_a_threshold_that_is_checked_while_something_runs_needs_hysteresis(workspace: Workspace, root: str) -> None:
    (told,) = found(workspace, below(root), "no-hysteresis")
    assert "may flap" in told


@pytest.mark.parametrize(("width", "told"), [("0 cm", "may flap"), ("-5 cm", "cannot be negative")])
def test_a_hysteresis_that_is_a_parameter_is_looked_at_with_its_value(
    workspace: Workspace, width: str, told: str
) -> None:
    root = below("reactive_sequence: [{condition: distance(p) < 1 m hysteresis h}, act]")
    assert not found(workspace, f"parameters: {{h: 5 cm}}\n{root}")
    (problem,) = found(workspace, f"parameters: {{h: {width}}}\n{root}")
    assert told in problem


@pytest.mark.parametrize(
    "root",
    [
        "reactive_sequence: [{condition: distance(p) < 1 m hysteresis 5 cm}, act]",
        "reactive_sequence: [{condition: seen(p)}, act]",
        "reactive_sequence: [{condition: state.time < 5 s}, act]",
        "reactive_sequence: [{confident: {percept: p, above: 0.6}}, {within: {percept: p, distance: 1}}, act]",
        "reactive_sequence: [{within: {percept: p, distance: 1, bearing_hysteresis: 0}}, act]",
        f"sequence: [{{{NEAR}}}, act]",
        f"selector: [{{inverter: {{{NEAR}}}}}, act]",
        "if: {condition: distance(p) < 1 m, then: act}",
        "switch: {value: distance(p) < 1 m, cases: {'true': act}}",
        f"reactive_sequence: [act, {{{NEAR}}}]",
        f"reactive_sequence: [{{{NEAR}}}, {{set_blackboard: {{key: k, value: 1}}}}]",
        f"parallel: [{{{NEAR}}}, act]",
        f"retry: {{attempts: -1, {NEAR}}}",
        "timeout: {duration: 9 s, wait_until: distance(p) < 1 m}",
        NEAR,
    ],
)
def test_a_threshold_that_cannot_flap_needs_none(workspace: Workspace, root: str) -> None:
    assert not found(workspace, below(root))


def test_the_hint_is_the_condition_with_hysteresis(workspace: Workspace) -> None:
    hints = {
        "distance(p) < 1 m": "distance(p) < 1 m hysteresis 5 cm",
        "abs(bearing(p)) <= 20 deg": "abs(bearing(p)) <= 20 deg hysteresis 5 deg",
        "p.confidence > 0.6": "p.confidence > 0.6 hysteresis 0.1",
        "state.standing and 1 m >= p.distance": "1 m >= ... hysteresis 5 cm",
        "distance(p) < 1 m hysteresis 0 m": "distance(p) < ... hysteresis 5 cm",
    }
    for text, hint in hints.items():
        (warning,) = load(workspace, below(f"reactive_sequence: [{{condition: '{text}'}}, act]")).warnings
        assert (warning.hint, warning.severity) == (hint, "warning")
        assert warning.place is not None and (warning.place.line, warning.place.column) == (2, 92)
    (warning,) = load(
        workspace, below("reactive_sequence: [{confident: {percept: p, above: 1, hysteresis: 0}}, act]")
    ).warnings
    assert warning.hint == "hysteresis: 0.1"
    assert warning.place is not None and (warning.place.line, warning.place.column) == (2, 127)


WALK = "approach: {target: p}"


@pytest.mark.parametrize(
    "root",
    [
        WALK,
        f"sequence: [act, {{{WALK}}}]",
        f"on_stale: act, repeat: {{{WALK}}}",
        f"sequence: [{{timeout: {{duration: 9 s, act: }}}}, {{{WALK}}}]",
        f"sequence: [{{condition: seen(p)}}, {{{WALK}}}]",
        f"parallel: {{success: one, children: [{{{WALK}}}, {{wait_until: state.standing}}, act]}}",
        f"parallel: [{{{WALK}}}, {{wait: 9 s}}]",
        f"parallel: {{success: one, children: [{{{WALK}}}, {{repeat: {{wait: 9 s}}}}]}}",
        "wait_until: seen(p)",
    ],
)
def test_what_may_run_for_ever_needs_a_time_limit(workspace: Workspace, root: str) -> None:
    told = found(workspace, below(root), "no-time-limit")
    assert told
    assert "may run for ever, and no timeout stands above it" in told[0]


@pytest.mark.parametrize(
    "root",
    [
        f"timeout: {{duration: 9 s, {WALK}}}",
        f"timeout: {{duration: 9 s, sequence: [act, {{inverter: {{{WALK}}}}}]}}",
        f"parallel: {{success: one, children: [{{{WALK}}}, {{wait: 9 s}}]}}",
        f"parallel: {{success: one, children: [{{{WALK}}}, {{sequence: [{{wait: 9 s}}, {{wait: 9 s}}]}}]}}",
        f"parallel: [{{{WALK}}}, {{inverter: {{wait: 9 s}}}}]",
        "reach: {target: p}",
        "selector: [act, idle]",
        "on_stale: idle, act:",
        "sequence: [act, plain, {wait: 1 s}]",
        "raise_emergency_stop: {reason: look}",
    ],
)
def test_what_ends_or_is_made_to_run_on_needs_none(workspace: Workspace, root: str) -> None:
    assert not found(workspace, below(root), "no-time-limit")


def test_a_skill_that_says_nothing_is_told_what_it_can_say(workspace: Workspace) -> None:
    (warning,) = load(workspace, below(WALK)).warnings
    assert warning.hint.startswith("timeout: {duration: 60 s, approach: ...}; or, in its class, bounded = True")
    file = workspace.root / "skills" / "test_skills.py"
    file.write_text(file.read_text().replace('resources = ("base", "gaze")', 'resources = ("base",); bounded = False'))
    (warning,) = load(workspace, below(WALK)).warnings
    assert warning.hint == "timeout: {duration: 60 s, approach: ...}"


def test_a_sub_tree_alone_does_not_know_its_time_limit(workspace: Workspace) -> None:
    text = "format: 1\nsubtree: true\nparameters: {p: p}\nroot: {approach: {target: $p}}\n"
    assert not found(workspace, text)
    (workspace.root / "trees" / "sub.yaml").write_text(text)
    assert not found(workspace, below("timeout: {duration: 9 s, subtree: sub}"))
    assert found(workspace, below("sequence: [{subtree: sub}, {subtree: sub}]")) == [
        "4:8 no-time-limit 'approach' may run for ever, and no timeout stands above it"
    ]
