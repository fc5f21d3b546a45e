from __future__ import annotations

from collections.abc import Callable
from functools import partial

import py_trees
import pytest
from py_trees.behaviour import Behaviour

from humanoid_bt.files.workspace import Workspace
from humanoid_bt.tree.nodes import ReactiveSequence, Selector, Sequence, Success
from tests.tree.helpers import run


@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        ("{sequence: [{act: {script: s}}, {act: {script: rs}}]}", "rs"),
        ("{sequence: [{act: {script: s}}, {act: {script: f}}, {act: {script: r}}]}", "f"),
        ("{selector: [{act: {script: f}}, {act: {script: rs}}]}", "rs"),
        ("{selector: [{act: {script: f}}, {act: {script: f}}]}", "f"),
        ("{reactive_sequence: [{act: {script: s}}, {act: {script: rs}}]}", "rs"),
        ("{reactive_sequence: [{act: {script: s}}, {act: {script: f}}, {act: {script: r}}]}", "f"),
        ("{reactive_selector: [{act: {script: f}}, {act: {script: rs}}]}", "rs"),
        ("{reactive_selector: [{act: {script: f}}, {act: {script: f}}]}", "f"),
    ],
)
def test_status_of_a_composite(workspace: Workspace, root: str, statuses: str) -> None:
    assert run(workspace, root).ticks(len(statuses)) == statuses


def test_reactive_sequence_checks_earlier_children_again_and_preempts(workspace: Workspace) -> None:
    reactive = run(workspace, "{reactive_sequence: [{act: {name: guard, script: ssf}}, {act: {name: work}}]}")
    assert reactive.ticks(3) == "rrf"
    assert reactive.log[-3:] == [("start", "guard"), ("FAILURE", "guard"), ("INVALID", "work")]


def test_sequence_goes_on_at_the_running_child(workspace: Workspace) -> None:
    sequence = run(workspace, "{sequence: [{act: {name: first, script: sf}}, {act: {name: work, script: rrs}}]}")
    assert sequence.ticks(4) == "rrsf"  # the third tick ends it: the fourth asks the first again
    assert [name for event, name in sequence.log if event == "start"] == ["first", "work", "first"]


def test_sequence_runs_one_thing_after_the_other(workspace: Workspace) -> None:
    walk, turn = "{timeout: {duration: 9, act: {name: walk, script: rrs}}}", "{timeout: {duration: 9, wait: 0.1}}"
    sequence = run(workspace, f"{{sequence: [{walk}, {turn}]}}")
    assert sequence.ticks(4) == "rrrs"
    assert sequence.log == [("start", "walk"), ("SUCCESS", "walk")]


def test_a_halted_selector_begins_anew(workspace: Workspace) -> None:
    selector = run(workspace, "{selector: [{act: {name: first, script: f}}, {act: {name: second}}]}")
    selector.ticks(2)
    selector.executor.halt("test")
    selector.log.clear()
    selector.tick()
    assert [name for event, name in selector.log if event == "start"] == ["first", "second"]


def test_reactive_selector_preempts_a_later_child_after_the_earlier_one_took_over(workspace: Workspace) -> None:
    selector = run(workspace, "{reactive_selector: [{act: {name: high, script: fr}}, {act: {name: low}}]}")
    selector.ticks(2)
    assert selector.log == [
        ("start", "high"),
        ("FAILURE", "high"),
        ("start", "low"),
        ("start", "high"),
        ("INVALID", "low"),
    ]


def test_a_branch_that_is_left_does_not_keep_an_old_result(workspace: Workspace) -> None:
    left = run(workspace, "{sequence: [{act: {name: a, script: sf}}, {act: {name: b, script: f}}]}")
    left.tick()
    assert ("b", "FAILURE") in left.told()
    left.tick()
    assert left.told() == [("a", "FAILURE"), ("b", "INVALID")]
    assert left.log.count(("INVALID", "b")) == 0  # it had ended, so it is not told


@pytest.mark.parametrize(("name", "type_name"), [("fallback", "selector"), ("reactive_fallback", "reactive_selector")])
def test_fallback_is_another_name_of_a_selector(workspace: Workspace, name: str, type_name: str) -> None:
    assert run(workspace, f"{{{name}: [act]}}").tree.nodes[0].type_name == type_name


@pytest.mark.parametrize(("composite", "remembers"), [(Sequence, True), (ReactiveSequence, False)])
def test_py_trees_is_told_whether_it_goes_on(composite: type[Sequence], remembers: bool) -> None:
    assert composite("all", [Success("done")]).memory is remembers
    assert ("{-}" in py_trees.display.ascii_tree(composite("all", [Success("done")]))) is remembers


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (partial(Sequence, memory=True), "Sequence has no parameter 'memory': leave it out: 'sequence' goes on with"),
        (partial(Selector, memory=False), "Selector has no parameter 'memory': use 'reactive_selector', which asks"),
        (partial(ReactiveSequence, memory=True), "no parameter 'memory': use 'sequence', which goes on with what runs"),
    ],
)
def test_memory_is_answered_in_python(make: Callable[..., Behaviour], message: str) -> None:
    with pytest.raises(TypeError, match=message):
        make("all", children=[Success("done")])
