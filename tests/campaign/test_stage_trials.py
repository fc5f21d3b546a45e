"""What is told of a trial on the stage: its outcome, and which node of its tree its reason is about."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from humanoid_bt.campaign.result import Result
from humanoid_bt.campaign.stage_trials import Setup, judged, make, result_of
from humanoid_bt.campaign.trial import Task, Trial

HARMLESS = "{condition: {name: harmless, expression: state.x > 5 m}}"
CULPRIT = "{condition: {name: culprit, expression: state.y > 5 m}}"


def tried(workspace: Path, root: str, *script: dict[str, Any], duration: float = 1.0) -> Result:
    (workspace / "trees").mkdir()
    (workspace / "trees/blame.yaml").write_text(f"format: 1\nroot: {root}\n", encoding="utf-8")
    trial = Trial(0, "blame", "humanoid", "empty", 0, duration=duration, dry=True)
    return make(Setup(str(workspace), script))(Task(trial))[0]


@pytest.mark.parametrize(
    ("root", "node", "reason"),
    [
        (
            f"{{sequence: [{{selector: [{HARMLESS}, {{log: ok}}]}}, {CULPRIT}]}}",
            "sequence/culprit",
            "culprit: state.y ",
        ),
        ("{timeout: {duration: 0.1 s, wait: 1 s}}", "timeout", "timeout: timed out "),
        ("{wait: 9 s}", "wait", "the tree still ran after 0.2 s at "),
    ],
)
def test_the_node_is_the_one_that_the_reason_names(tmp_path: Path, root: str, node: str, reason: str) -> None:
    result = tried(tmp_path, root, duration=0.2)
    assert result.node == f"blame/{node}"
    assert result.reason.startswith(reason)


def test_the_node_is_the_leaf_that_did_something_last(tmp_path: Path) -> None:
    waits = "{sequence: [{wait: {name: first, duration: 0.1 s}}, {wait: {name: second, duration: 9 s}}]}"
    result = tried(tmp_path, f"{{emergency_stop: {waits}}}", {"at": 0.2, "estop": "mine"})
    assert (result.outcome, result.node.rpartition("/")[2]) == ("stopped", "second")


def _run(**report: Any) -> Any:
    given = {"results": [], "touches": [], "bumps": [], "stops": [], "sim_time": 1.0, **report}
    return SimpleNamespace(
        **{"report": SimpleNamespace(**given), "outcome": "success", "reason": "", "succeeded": True, "fell": False},
        **{"missed": [], "trace": "", "stops": []},
    )


def test_what_a_hand_was_sent_to_is_not_bumped_into() -> None:
    touches = [{"thing": "box", "meant": True}, {"thing": "wall", "meant": False}, {"thing": "wall", "meant": False}]
    assert result_of(_run(touches=touches)).bumped == "wall"


def test_a_number_that_is_none_is_left_out_of_results() -> None:
    told = [{"name": "a", "value": float("nan"), "unit": "m"}, {"name": "b", "value": 1.0, "unit": "m"}]
    assert dict(result_of(_run(results=told)).values) == {"b": 1.0}


def test_a_failure_keeps_its_own_outcome_whatever_else_counts() -> None:
    failed = Result("failure", "too far", fell=True)
    assert judged(failed, _run(), ["fell"]) == failed
    assert judged(replace(failed, outcome="success"), _run(), ["fell"]).outcome == "fell"
