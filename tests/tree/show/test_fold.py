"""Folding: as little as it takes, and never what runs."""

from __future__ import annotations

import pytest
from py_trees.common import Status

from humanoid_bt.files.workspace import Workspace, builtin_root
from humanoid_bt.tree.show import Outline, OutlineNode, outline_of, unicode_tree
from humanoid_bt.tree.show.fold import fitted, folded_below, without_subtrees
from humanoid_bt.tree.source.load import load_tree
from tests.tree.drawings import random_outline

OUTLINE = Outline(
    "t",
    "",
    (
        OutlineNode("r", "root", "sequence", "composite", -1),
        OutlineNode("r/a", "a", "sequence", "composite", 0),
        OutlineNode("r/a/x", "x", "x", "skill", 1),
        OutlineNode("r/b", "b", "b", "skill", 0),
        OutlineNode("r/w", "w", "watchdog", "decorator", 0),
        OutlineNode("r/w/c", "c", "timeout", "decorator", 4),
        OutlineNode("r/w/c/y", "y", "y", "skill", 5),
        OutlineNode("r/i", "i", "sequence", "composite", 0),
        OutlineNode("r/i/z", "z", "z", "skill", 7),
        OutlineNode("r/i/o", "o", "o", "skill", 7, branch="otherwise"),
    ),
)
RUNS, DONE, IDLE = Status.RUNNING, Status.SUCCESS, Status.INVALID
STATUSES = dict(
    zip(
        [node.path for node in OUTLINE.nodes], [RUNS, DONE, DONE, DONE, RUNS, RUNS, RUNS, IDLE, IDLE, IDLE], strict=True
    )
)


def drawn(room: int) -> list[str]:
    return unicode_tree(fitted(OUTLINE, STATUSES, lambda tree: len(tree.nodes) <= room), STATUSES).splitlines()[1:]


def test_a_tree_that_fits_is_not_fitted() -> None:
    assert fitted(OUTLINE, STATUSES, lambda tree: len(tree.nodes) <= 10) == OUTLINE


def test_what_is_idle_is_folded_first_then_what_has_ended() -> None:
    assert "   └─ ○ i (sequence)  2 below" in drawn(9)
    assert "   ├─ ✓ a (sequence)" in drawn(9)
    assert "   ├─ ✓ a (sequence)  1 below" in drawn(7)


def test_an_only_child_joins_its_parent_then_siblings_at_rest_each_other() -> None:
    assert drawn(5) == [
        "└─ ▶ root (sequence)",
        "   ├─ ✓ a (sequence)  1 below",
        "   ├─ ✓ b",
        "   ├─ ▶ w / c / y",
        "   └─ ○ i (sequence)  2 below",
    ]
    assert drawn(4) == ["└─ ▶ root (sequence)", "   ├─ ✓ a, b", "   ├─ ▶ w / c / y", "   └─ ○ i (sequence)  2 below"]


def test_at_last_only_what_runs_is_left() -> None:
    assert drawn(1) == ["└─ ▶ root / w / c / y"]


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("room", [1, 8, 25])
def test_what_runs_is_there_however_little_room_there_is(seed: int, room: int) -> None:
    outline = random_outline(seed)
    running = outline.nodes[-1 - seed % 20]
    statuses = {node.path: list(Status)[hash_of(node.path) % 4] for node in outline.nodes}
    statuses = {path: DONE if status is RUNS else status for path, status in statuses.items()}
    node = running
    while True:
        statuses[node.path] = RUNS
        if node.parent < 0:
            break
        node = outline.nodes[node.parent]
    found = fitted(outline, statuses, lambda tree: len(tree.nodes) <= room)
    assert running.path in [node.path for node in found.nodes]
    assert all(node.parent < index for index, node in enumerate(found.nodes))
    assert len(found.nodes) <= max(room, 1) or len(found.nodes) == 1


def hash_of(text: str) -> int:
    return sum(text.encode())


def test_the_lowest_are_kept_below_a_line_that_counts_the_others() -> None:
    busy = dict.fromkeys(STATUSES, RUNS)
    found = fitted(OUTLINE, busy, lambda tree: len(tree.nodes) <= 4)
    assert [node.name for node in found.nodes] == ["4 more above", "i", "z", "o"]
    assert [node.parent for node in found.nodes] == [-1, 0, 1, 1]


@pytest.fixture(scope="module")
def tour() -> Outline:
    workspace = Workspace(builtin_root())
    return outline_of(load_tree(workspace.find_tree("tour"), workspace))


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
