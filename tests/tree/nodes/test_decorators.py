from __future__ import annotations

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.files.workspace import Workspace
from tests.tree.helpers import run


@pytest.mark.parametrize(
    ("root", "statuses"),
    [
        ("{inverter: {act: {script: rs}}}", "rf"),
        ("{inverter: {act: {script: rf}}}", "rs"),
        ("{retry: {attempts: 3, act: {script: fffs}}}", "rrf"),
        ("{retry: {attempts: 3, act: {script: ffs}}}", "rrs"),
        ("{retry: {attempts: -1, act: {script: fffffs}}}", "rrrrrs"),
        ("{repeat: {times: 3, act: {script: srss}}}", "rrrs"),
        ("{repeat: {times: 3, act: {script: sf}}}", "rf"),
        ("{repeat: {act: {script: s}}}", "rrrrr"),
    ],
)
def test_status_of_a_decorator(workspace: Workspace, root: str, statuses: str) -> None:
    assert run(workspace, root).ticks(len(statuses)) == statuses


def test_retry_counts_afresh_and_says_where_it_is(workspace: Workspace) -> None:
    retry = run(workspace, "{retry: {attempts: 2, act: {script: f}}}")
    assert retry.ticks(4) == "rfrf"
    assert retry.feedback("retry") == "attempt 2 of 2 failed"


def test_repeat_counts_afresh(workspace: Workspace) -> None:
    repeat = run(workspace, "{repeat: {times: 2, act: {script: s}}}")
    assert repeat.ticks(4) == "rsrs"
    assert repeat.feedback("repeat") == "done 2 of 2"


@pytest.mark.parametrize("root", ["{retry: {attempts: 0, act: }}", "{repeat: {times: 0, act: }}"])
def test_a_count_of_zero_is_refused(workspace: Workspace, root: str) -> None:
    with pytest.raises(UserError, match="must be at least 1, or -1 for ever"):
        run(workspace, root)


def test_timeout_halts_at_the_deadline_before_the_child_is_ticked(workspace: Workspace) -> None:
    timeout = run(workspace, "{timeout: {duration: 0.3 s, act: {script: rrrs}}}")
    assert timeout.ticks(4) == "rrrf"  # the success of the deadline's own tick does not count
    assert timeout.log == [("start", "act"), ("INVALID", "act")]
    assert timeout.feedback("timeout") == "timed out after 0.3 s (limit 0.3 s)"
    assert timeout.feedback("act") == "halted: timed out after 0.3 s"


def test_timeout_measures_each_run_from_its_start(workspace: Workspace) -> None:
    timeout = run(workspace, "{timeout: {duration: 300 ms, act: {script: rsrrs}}}")
    assert timeout.ticks(5) == "rsrrs"
