"""The sub-tree ``handover`` on the simulated robot."""

import numpy as np
import pytest

from tests.session.helpers import Ran
from tests.trees.conftest import RunTree, ended, stance

HANDOVER = """\
watchdog:
  percept: person
  max_age: 1 s
  subtree: {{tree: handover, person: person{}}}
"""


def hands_are_back(run: Ran) -> bool:
    state = run.session.engine.sense()[0]
    return all(np.linalg.norm(palm[:2] - state.stance[:2]) < 0.35 for palm in state.hands.values())


@pytest.mark.trials
def test_walks_up_holds_the_hand_out_and_steps_back(run_tree: RunTree) -> None:
    run = run_tree(HANDOVER.format(", taken: {wait: 3 s}"), "visitor_ahead")
    assert run.report.outcome == "success", run.report.reason
    assert ended(run, "approach") == ended(run, "retract") == ended(run, "step_back") == ["success"]
    x, y, _ = stance(run)
    assert np.hypot(0.9 - x, 0.15 - y) == pytest.approx(0.95, abs=0.15)
    assert hands_are_back(run)


@pytest.mark.trials
def test_fails_with_the_hand_back_when_nobody_comes(run_tree: RunTree) -> None:
    run = run_tree(HANDOVER.format(", patience: 1 s, taken: {wait: 60 s}"), "visitor_ahead")
    assert run.report.outcome == "failure"
    assert ended(run, "offer") == ["success"]  # it was there, and its time is over
    assert ended(run, "step_back") == ["success"]
    assert hands_are_back(run)


@pytest.mark.trials
def test_fails_with_the_hand_back_when_it_cannot_offer(run_tree: RunTree) -> None:
    run = run_tree(HANDOVER.format(", near: 30 cm"), "visitor_ahead")
    assert run.report.outcome == "failure"
    assert ended(run, "offer") == ["failure"]
    assert ended(run, "step_back") == ["success"]
