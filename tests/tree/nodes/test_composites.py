from __future__ import annotations

import pytest

from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import run


@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        ("{sequence: [{act: {script: s}}, {act: {script: rs}}]}", "rs"),
        ("{sequence: [{act: {script: s}}, {act: {script: f}}, {act: {script: r}}]}", "f"),
        ("{selector: [{act: {script: f}}, {act: {script: rs}}]}", "rs"),
        ("{selector: [{act: {script: f}}, {act: {script: f}}]}", "f"),
    ],
)
def test_status_of_a_composite(workspace: Workspace, root: str, statuses: str) -> None:
    assert run(workspace, root).ticks(len(statuses)) == statuses


def test_reactive_sequence_checks_earlier_children_again_and_preempts(workspace: Workspace) -> None:
    reactive = run(workspace, "{sequence: [{act: {name: guard, script: ssf}}, {act: {name: work}}]}")
    assert reactive.ticks(3) == "rrf"
    assert reactive.log[-3:] == [("start", "guard"), ("FAILURE", "guard"), ("INVALID", "work")]


def test_sequence_with_memory_goes_on_at_the_running_child(workspace: Workspace) -> None:
    memory = run(
        workspace,
        "{sequence: {memory: true, children: [{act: {name: guard, script: sf}}, {act: {name: work, script: rrs}}]}}",
    )
    assert memory.ticks(4) == "rrsf"  # memory ends with the sequence: the fourth tick asks the guard again
    assert [name for event, name in memory.log if event == "start"] == ["guard", "work", "guard"]


def test_memory_is_lost_by_a_halt(workspace: Workspace) -> None:
    memory = run(
        workspace,
        "{selector: {memory: true, children: [{act: {name: first, script: f}}, {act: {name: second}}]}}",
    )
    memory.ticks(2)
    memory.executor.halt("test")
    memory.log.clear()
    memory.tick()
    assert [name for event, name in memory.log if event == "start"] == ["first", "second"]


def test_reactive_selector_preempts_a_later_child_after_the_earlier_one_took_over(workspace: Workspace) -> None:
    selector = run(workspace, "{selector: [{act: {name: high, script: fr}}, {act: {name: low}}]}")
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
