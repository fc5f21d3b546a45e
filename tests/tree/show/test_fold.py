"""Folding: as little as it takes, and never what runs."""

from __future__ import annotations

import pytest
from py_trees.common import Status

from humanoid_bt.tree.show import Outline, OutlineNode, unicode_tree
from humanoid_bt.tree.show.fold import folded, lowest
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
    return unicode_tree(folded(OUTLINE, STATUSES, lambda tree: len(tree.nodes) <= room), STATUSES).splitlines()[1:]


def test_a_tree_that_fits_is_not_folded() -> None:
    assert folded(OUTLINE, STATUSES, lambda tree: len(tree.nodes) <= 10) == OUTLINE


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
    found = folded(outline, statuses, lambda tree: len(tree.nodes) <= room)
    assert running.path in [node.path for node in found.nodes]
    assert all(node.parent < index for index, node in enumerate(found.nodes))
    assert len(found.nodes) <= max(room, 1) or len(found.nodes) == 1


def hash_of(text: str) -> int:
    return sum(text.encode())


def test_the_lowest_are_kept_below_a_line_that_counts_the_others() -> None:
    found = lowest(OUTLINE, 4)
    assert [node.name for node in found.nodes] == ["7 more above", "i", "z", "o"]
    assert [node.parent for node in found.nodes] == [-1, 0, 1, 1]
    assert lowest(OUTLINE, 10) is OUTLINE
