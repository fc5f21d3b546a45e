"""The sub-tree ``greet`` on the simulated robot."""

import pytest

from tests.trees.conftest import RunTree, ended

GREET = """\
watchdog:
  percept: person
  max_age: 1 s
  subtree: {{tree: greet, person: person{}}}
"""


def test_looks_and_waves_and_takes_the_hand_back(run_tree: RunTree) -> None:
    run = run_tree(GREET.format(", times: 1"), "visitor_ahead")
    assert run.report.outcome == "success", run.report.reason
    assert ended(run, "wave") == ended(run, "retract") == ["success"]


@pytest.mark.trials
def test_does_not_greet_again_for_some_time(run_tree: RunTree) -> None:
    twice = GREET.format(", times: 1, again: 2 s").replace("  subtree", "  keep_running_until_failure:\n    subtree")
    run = run_tree(twice, "visitor_ahead")
    assert run.report.outcome == "failure"
    assert ended(run, "wave") == ["success"]
    assert ended(run, "cooldown") == ["success", "failure"]


@pytest.mark.trials
def test_greets_again_afterwards(run_tree: RunTree) -> None:
    twice = GREET.format(", times: 1, again: 2 s").replace(
        "  subtree", "  repeat:\n    times: 2\n    failure_is_running:\n      subtree"
    )
    run = run_tree(twice, "visitor_ahead")
    assert run.report.outcome == "success"
    assert ended(run, "wave") == ["success", "success"]
