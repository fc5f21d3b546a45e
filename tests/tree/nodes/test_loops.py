"""Loops: what ``for_each`` hands out."""

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.decision.blackboard import Key
from humanoid_bt.files.workspace import Workspace
from humanoid_bt.session.setting import setting
from humanoid_bt.tree.nodes import Condition, ForEach
from humanoid_bt.tree.source.compose import make_tree
from tests.tree.helpers import Run, load

PARTS = "root: {for_each: {item: [x, script], items: [[1, s], [2, s]], sequence: [{act: {script: $script}}, %s]}}"


@pytest.mark.parametrize(("condition", "ticks"), [("x == 1 or x == 2", "rs"), ("x == 1", "rf")])
def test_the_parts_of_an_item_go_to_several_keys(workspace: Workspace, condition: str, ticks: str) -> None:
    assert Run(load(workspace, PARTS % f"condition: {condition}")).ticks(2) == ticks


def test_keys_that_are_left_over_get_null(workspace: Workspace) -> None:
    run = Run(load(workspace, "root: {for_each: {item: [x, y], items: [[1, 2], [3]], condition: x > 0 and is_set(y)}}"))
    assert run.ticks(2) == "rs"
    x, y = run.tree.nodes[0].values["item"]
    assert (x.value, y.value) == (3, None)


@pytest.mark.parametrize(("items", "number"), [("[1]", 1), ("[[1, 2], [1, 2, 3]]", 2), ("[[]]", 1)])
def test_items_that_cannot_be_handed_out_are_refused(workspace: Workspace, items: str, number: int) -> None:
    with pytest.raises(UserError, match=f"item {number} must be a list with at most 2 parts"):
        load(workspace, f"root: {{for_each: {{item: [x, y], items: {items}, condition: x > 0 and is_set(y)}}}}")


@pytest.mark.parametrize("names", [["x", "y"], [Key("x"), Key("y")]])
def test_in_python_it_shares_keys_by_name_and_is_written(workspace: Workspace, names: list[Key]) -> None:
    same = Condition("same", expression="x == y")
    tree = make_tree(ForEach("each", same, item=names, items=[[1, 1], [2, 2]]), workspace)
    assert "item: [x, y]" in tree.to_yaml()
    assert Run(tree).ticks(2) == "rs"


def test_items_that_are_set_while_it_runs_are_for_its_next_run(workspace: Workspace) -> None:
    each = "for_each: {item: x, items: [1, 2, 3], condition: x > 0}"
    run = Run(load(workspace, f"root: {{repeat: {{times: 2, {each}}}}}"))
    assert run.ticks(1) == "r"
    setting(run.tree, "for_each.items", [4]).apply()
    assert run.ticks(1) == "r"
    assert run.feedback("for_each") == "x 2 of 3: 2"
    assert run.ticks(2) == "rs"
    assert run.feedback("for_each") == "x 1 of 1: 4"
