"""Which node of its tree a trial's reason is about."""

from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.campaign.stage_trials import Setup, make
from humanoid_bt.campaign.trial import Task, Trial

HARMLESS = "{condition: {name: harmless, expression: state.x > 5 m}}"
CULPRIT = "{condition: {name: culprit, expression: state.y > 5 m}}"


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
    (tmp_path / "trees").mkdir()
    (tmp_path / "trees/blame.yaml").write_text(f"format: 1\nroot: {root}\n", encoding="utf-8")
    trial = Trial(0, "blame", "humanoid", "empty", 0, duration=0.2, dry=True)
    result = make(Setup(str(tmp_path)))(Task(trial))[0]
    assert result.node == f"blame/{node}"
    assert result.reason.startswith(reason)
