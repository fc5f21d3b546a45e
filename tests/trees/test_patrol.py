"""The sub-tree ``patrol`` on the simulated robot."""

import math

import pytest

from tests.trees.conftest import RunTree, ended, stance


@pytest.mark.trials
def test_comes_to_the_places_in_their_order(run_tree: RunTree) -> None:
    run = run_tree("""\
    sequence:
      - subtree:
          tree: patrol
          places: [[30 cm, 0], [0.3, 0.3, 90 deg]]
          visited: visited
          task: {wait: 100 ms}
      - condition: visited == 2
    """)
    assert run.report.outcome == "success", run.report.reason
    assert ended(run, "walk_to") == ended(run, "wait") == ["success", "success"]
    x, y, heading = stance(run)
    assert math.hypot(x - 0.3, y - 0.3) < 0.1
    assert heading == pytest.approx(math.radians(90), abs=0.15)


def test_looks_around_where_it_comes_to_unless_told_otherwise(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: patrol, places: [[0, 0, 0]]}")
    assert run.report.outcome == "success", run.report.reason
    assert ended(run, "look around") == ["success"]


@pytest.mark.trials
def test_walks_several_rounds(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: patrol, places: [[0, 0, 0], [0, 0, 20 deg]], rounds: 2, task: {wait: 0 s}}")
    assert run.report.outcome == "success", run.report.reason
    assert ended(run, "walk_to") == ["success"] * 4


def test_fails_at_a_place_that_it_does_not_come_to_in_time(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: patrol, places: [[9, 0], [0, 0]], patience: 1 s}")
    assert run.report.outcome == "failure"
    assert not ended(run, "look around")
