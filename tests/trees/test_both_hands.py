"""Both hands at once on the simulated robot: looking is a choice."""

from __future__ import annotations

import pytest

from humanoid_bt.core.errors import UserError
from tests.trees.conftest import RunTree, ended

BOTH = """\
watchdog:
  percept: left
  max_age: 1 s
  watchdog:
    percept: right
    max_age: 1 s
    parallel:
      - reach: {{name: one, target: left, hand: left, look: {}}}
      - reach: {{name: other, target: right, hand: right, look: {}}}
"""


@pytest.mark.parametrize(
    "looks",
    [
        ("true", "false"),
        pytest.param(("false", "true"), marks=pytest.mark.trials),
        pytest.param(("false", "false"), marks=pytest.mark.trials),
    ],
)
def test_both_hands_reach_at_once_if_at_most_one_looks(run_tree: RunTree, looks: tuple[str, str]) -> None:
    run = run_tree(BOTH.format(*looks), "two_balls")
    report = run.report
    assert report.outcome == "success", report.reason
    assert ended(run, "one") == ended(run, "other") == ["success"]
    assert report.result("one/hand_error") < 0.02
    assert report.result("other/hand_error") < 0.02
    assert report.stops == []


def test_two_that_look_cannot_run_at_once(run_tree: RunTree) -> None:
    with pytest.raises(UserError, match="'one' and 'other' run at once and both command gaze") as raised:
        run_tree(BOTH.format("true", "true"), "two_balls")
    assert "look: false in 'other' leaves gaze alone" in raised.value.problems[0].hint


def test_a_hand_that_the_other_one_keeps_from_the_ball_says_so(run_tree: RunTree) -> None:
    both = """\
watchdog:
  percept: left
  max_age: 1 s
  parallel:
    - reach: {name: one, target: left, hand: left, look: true, hold: 20 s}
    - reach: {name: other, target: left, hand: right, look: false, hold: 20 s}
"""
    run = run_tree(both, "two_balls")
    assert run.report.outcome == "failure"
    assert run.report.reason.endswith(" hand is in the way"), run.report.reason
    assert not run.report.fell
