"""The sub-tree ``recover`` on the simulated robot."""

import math

import pytest

from tests.trees.conftest import RunTree, ended, stance


def test_an_action_that_succeeds_at_once_needs_no_motion(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: recover, action: {stumble: {times: 0}}}")
    assert run.report.outcome == "success"
    assert run.report.sim_time < 0.1
    assert not ended(run, "step_back")


@pytest.mark.trials
def test_takes_the_hands_back_and_steps_back_before_it_tries_again(run_tree: RunTree) -> None:
    run = run_tree("""\
    sequence:
      - subtree: {tree: recover, distance: 20 cm, needed: needed, action: {stumble: {times: 2}}}
      - condition: needed == 3
    """)
    assert run.report.outcome == "success"
    assert ended(run, "stumble") == ["failure", "failure", "success"]
    assert ended(run, "retract") == ended(run, "step_back") == ["success", "success"]
    x, y, heading = stance(run)
    assert x == pytest.approx(-0.4, abs=0.1)
    assert abs(y) < 0.1 and abs(heading) < math.radians(10)


def test_fails_after_the_last_attempt_without_recovering_once_more(run_tree: RunTree) -> None:
    run = run_tree("subtree: {tree: recover, attempts: 2, action: {stumble: {times: 9}}}")
    assert run.report.outcome == "failure"
    assert ended(run, "stumble") == ["failure", "failure"]
    assert ended(run, "step_back") == ["success"]


def test_counts_afresh_each_time_it_is_used(run_tree: RunTree) -> None:
    run = run_tree("repeat: {times: 2, subtree: {tree: recover, rest: 0 s, action: {stumble: {times: 0}}}}")
    assert run.report.outcome == "success"
    assert not ended(run, "step_back")
