"""The sub-tree ``search`` on the simulated robot."""

import math

import pytest

from tests.trees.conftest import RunTree, ended, stance


def test_succeeds_at_once_when_the_target_is_in_sight(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: search, target: person}", "visitor_ahead")
    assert run.report.outcome == "success"
    assert run.report.sim_time < 1
    assert not ended(run, "turn")


@pytest.mark.trials
def test_turns_until_it_sees_what_is_behind(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: search, target: target, look: 1 s}", "ball_behind")
    assert run.report.outcome == "success", run.report.reason
    _, _, heading = stance(run)
    away = math.remainder(math.atan2(-0.9, -1.2) - heading, math.tau)
    assert abs(away) < math.radians(110)  # half the view, and as far as the neck turns


@pytest.mark.trials
def test_finds_what_is_low_and_straight_behind(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: search, target: target}", "ball_straight_behind")
    assert run.report.outcome == "success", run.report.reason


@pytest.mark.trials
def test_goes_the_other_way_round_with_a_negative_step(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: search, target: target, look: 1 s, step: -60 deg}", "ball_behind")
    assert run.report.outcome == "success", run.report.reason
    assert stance(run)[2] < 0


@pytest.mark.trials
def test_fails_when_it_has_turned_as_often_as_told(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: search, target: nothing, look: 0.2 s, step: 40 deg, turns: 2}")
    assert run.report.outcome == "failure"
    assert ended(run, "turn") == ["success", "success"]
    assert stance(run)[2] == pytest.approx(math.radians(80), abs=0.2)


def test_fails_when_its_time_is_over(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: search, target: nothing, patience: 1 s}")
    assert run.report.outcome == "failure"
    assert run.report.sim_time == pytest.approx(1, abs=0.1)


@pytest.mark.trials
def test_brings_a_watchdogs_target_back(run_tree: RunTree) -> None:
    run = run_tree(
        """\
        watchdog:
          percept: target
          max_age: 0.5 s
          on_stale: {subtree: {tree: search, target: target, look: 0.5 s}}
          look_at: {target: target}
        """,
        "ball_behind",
    )
    assert run.report.outcome == "success", run.report.reason
    assert ended(run, "look_at") == ["success"]
