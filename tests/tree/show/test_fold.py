"""Trees in less room."""

from __future__ import annotations

import random

import pytest
from py_trees.common import Status

from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.show import Outline, outline_of
from humanoid_bt.tree.show.fold import fitted, folded_below, without_subtrees
from humanoid_bt.tree.source.load import load_tree
from tests.tree.drawings import random_outline


@pytest.fixture(scope="module")
def tour() -> Outline:
    workspace = Workspace(builtin_root())
    return outline_of(load_tree(workspace.find_tree("tour"), workspace))


def running(outline: Outline, leaf: int, seed: int) -> dict[str, Status]:
    """Return statuses of a moment in which a leaf and all above it run, and anything else may have ended."""
    choose = random.Random(seed)
    ended = [Status.SUCCESS, Status.FAILURE, Status.INVALID]
    statuses = {node.path: choose.choice(ended) for node in outline.nodes}
    index = leaf
    while index >= 0:
        statuses[outline.nodes[index].path] = Status.RUNNING
        index = outline.nodes[index].parent
    return statuses


@pytest.mark.parametrize(("width", "height"), [(80, 23), (60, 23), (80, 8), (140, 50)])
def test_what_runs_deepest_is_always_in_sight(tour: Outline, width: int, height: int) -> None:
    inner = {node.parent for node in tour.nodes}
    leaves = [index for index in range(len(tour.nodes)) if index not in inner]
    assert len(tour.nodes) > 50
    for leaf in leaves:
        statuses = running(tour, leaf, leaf)
        said = dict.fromkeys(statuses, "a few words on how it goes")
        shown, lines = fitted(tour, statuses, said, width, height)
        assert len(lines) <= height
        assert tour.nodes[leaf].path in {shown.nodes[line.node].path for line in lines if line.node >= 0}
        assert lines[0].text.startswith("tour")


def test_a_tree_that_fits_is_shown_whole(tour: Outline) -> None:
    statuses = {node.path: Status.INVALID for node in tour.nodes}
    shown, lines = fitted(tour, statuses, {}, 200, 500)
    assert shown is tour
    assert {line.node for line in lines} == {-1, *range(len(tour.nodes))}


def test_what_is_left_out_is_counted(tour: Outline) -> None:
    statuses = running(tour, len(tour.nodes) - 1, 0)
    said = dict.fromkeys(statuses, "a few words on how it goes")
    _, every = fitted(tour, statuses, said, 80, 1000)
    _, lines = fitted(tour, statuses, said, 80, 8)
    assert len(every) > 8
    assert any(line.guide.endswith(("lines above", "lines below")) for line in lines)


@pytest.mark.parametrize("depth", [1, 2, 4])
def test_a_depth_folds_what_is_deeper(depth: int) -> None:
    outline = random_outline(3)
    shown = folded_below(outline, depth)
    counted = sum(int(node.parameters[-1].split()[0]) for node in shown.nodes if _folds(node.parameters))
    assert len(shown.nodes) + counted == len(outline.nodes)
    deepest = 0
    for node in shown.nodes:
        steps, at = 1, node
        while at.parent >= 0:
            steps, at = steps + 1, shown.nodes[at.parent]
        deepest = max(deepest, steps)
    assert deepest <= depth


def test_sub_trees_are_closed(tour: Outline) -> None:
    shown = without_subtrees(tour)
    assert [node.kind for node in shown.nodes].count("subtree") == 1
    assert shown.nodes[-1].parameters[-1] == f"{len(tour.nodes) - len(shown.nodes)} below"


def _folds(parameters: tuple[str, ...]) -> bool:
    return bool(parameters) and parameters[-1].endswith(" below")
