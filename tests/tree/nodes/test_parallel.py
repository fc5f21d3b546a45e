from __future__ import annotations

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import run


@pytest.mark.parametrize(
    ("thresholds", "scripts", "statuses"),
    [
        ("", ["rs", "rrs"], "rrs"),
        ("success: one,", ["r", "rs"], "rs"),
        ("success: 2,", ["r", "rs", "s"], "rs"),
        ("", ["r", "rf"], "rf"),
        ("failure: all,", ["f", "rrf"], "rrf"),
        ("failure: 2,", ["f", "r", "rf"], "rf"),
        ("failure: 2,", ["f", "rs", "s"], "rf"),  # all ended, but not all succeeded
        ("success: one,", ["s", "f"], "f"),  # both thresholds in one tick
    ],
)
def test_thresholds(workspace: Workspace, thresholds: str, scripts: list[str], statuses: str) -> None:
    children = ", ".join(f"{{act: {{script: {script}}}}}" for script in scripts)
    assert run(workspace, f"{{parallel: {{{thresholds} children: [{children}]}}}}").ticks(len(statuses)) == statuses


def test_children_that_ended_are_not_ticked_again_and_the_rest_is_halted_at_the_end(workspace: Workspace) -> None:
    parallel = run(
        workspace,
        "{parallel: {success: 2, children: [{act: {name: early, script: s}}, {act: {name: late, script: rrs}}, "
        "{act: {name: rest}}]}}",
    )
    assert parallel.ticks(3) == "rrs"
    assert parallel.log.count(("start", "early")) == 1
    assert parallel.log[-1] == ("INVALID", "rest")
    parallel.tick()
    assert parallel.log.count(("start", "early")) == 2  # a new run starts every child


@pytest.mark.parametrize("threshold", ["4", "0", "some", "1.5", "true"])
def test_a_threshold_that_cannot_be_is_refused(workspace: Workspace, threshold: str) -> None:
    with pytest.raises(UserError, match="'success'"):
        run(workspace, f"{{parallel: {{success: {threshold}, children: [act, act]}}}}")


@pytest.mark.parametrize(("threshold", "decides"), [("success: one, failure: 2", "good"), ("success: 2", "bad")])
def test_its_tip_is_the_child_that_decided(workspace: Workspace, threshold: str, decides: str) -> None:
    children = "[act: {name: good, script: s}, act: {name: bad, script: f}, act: {name: long}]"
    under_test = run(workspace, f"{{parallel: {{{threshold}, children: {children}}}}}")
    under_test.tick()
    tip = under_test.tree.root.tip()
    assert tip is not None
    assert tip.name == decides


def test_its_tip_is_a_child_that_runs(workspace: Workspace) -> None:
    under_test = run(workspace, "{parallel: [act: {name: long}, sequence: [act: {script: rs}, act: {script: s}]]}")
    tips = []
    for _ in range(3):
        under_test.tick()
        tip = under_test.tree.root.tip()
        assert tip is not None
        tips.append(tip.name)
    assert tips == ["act", "long", "long"]
