"""Where the nodes of a drawing go."""

from __future__ import annotations

import itertools
import random

import pytest

from humanoid_bt.tree.show.layout import Box, tidy
from tests.tree.drawings import random_outline

GAP = (30.0, 10.0)


def laid_out(seed: int) -> tuple[list[int], list[Box]]:
    """Return the parents of a tree of any shape, and the boxes of its nodes."""
    parents = [node.parent for node in random_outline(seed).nodes]
    choose = random.Random(seed)
    sizes = [(choose.uniform(10, 300), choose.uniform(10, 200)) for _ in parents]
    return parents, tidy(parents, sizes, GAP, [choose.choice((0.0, 50.0)) for _ in parents], apart=7.0)


@pytest.mark.parametrize("seed", range(30))
def test_no_two_boxes_overlap_or_touch(seed: int) -> None:
    _, boxes = laid_out(seed)
    for one, other in itertools.combinations(boxes, 2):
        beside = one.right + GAP[0] <= other.x or other.right + GAP[0] <= one.x
        above = one.bottom + GAP[1] <= other.y + 1e-9 or other.bottom + GAP[1] <= one.y + 1e-9
        assert beside or above


@pytest.mark.parametrize("seed", range(30))
def test_children_stand_right_of_their_parent_in_their_order(seed: int) -> None:
    parents, boxes = laid_out(seed)
    last: dict[int, Box] = {}
    for index, parent in enumerate(parents):
        if parent < 0:
            continue
        assert boxes[index].x >= boxes[parent].right + GAP[0]
        if parent in last:
            assert boxes[index].y >= last[parent].bottom
            assert boxes[index].x == last[parent].x
        else:
            assert boxes[index].y == boxes[parent].y
        last[parent] = boxes[index]


@pytest.mark.parametrize("seed", range(30))
def test_the_lines_to_children_of_different_parents_do_not_cross(seed: int) -> None:
    parents, boxes = laid_out(seed)
    below: dict[int, list[Box]] = {}
    for index, parent in enumerate(parents):
        below.setdefault(parent, []).append(boxes[index])
    spans = sorted((min(b.x for b in group), boxes[parent].y, group[-1].y) for parent, group in below.items())
    for (column, _, end), (next_column, start, _) in itertools.pairwise(spans):
        assert column != next_column or end < start


def test_a_leaf_moves_up_beside_what_is_deeper() -> None:
    boxes = tidy([-1, 0, 1, 1, 1, 0], [(10, 10)] * 6, GAP)
    assert boxes[5].y == 20
    assert boxes[4].y == 40


def test_room_for_labels_and_between_strangers_is_kept() -> None:
    boxes = tidy([-1, 0, 1, 0, 3], [(10, 10)] * 5, GAP, [0, 0, 0, 25, 0], apart=5.0)
    assert boxes[3].x == 10 + 30 + 25
    assert boxes[4].y == boxes[3].y == 10 + 10 + 5


def test_a_tree_of_nothing_has_no_boxes() -> None:
    assert tidy([], [], GAP) == []
