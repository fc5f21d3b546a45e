"""Trees that are edited while they run."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.projects import make_project
from tests.semantics.claims import shows
from tests.session.helpers import Ran
from tests.session.test_watch import edited, started, watched

WALK = "format: 1\nroot: {emergency_stop: walk}\n"
BROKEN = "format: 1\nroot: {emergency_stop: {wak: }}\n"
ONCE = """\
format: 1
blackboard: {n: 0}
root:
  emergency_stop:
    sequence:
      - once: {set_blackboard: {key: n, expression: n + 1}}
      - condition: n == 1
      - wait: 1 s
"""


@pytest.fixture(scope="module")
def swapped(tmp_path_factory: pytest.TempPathFactory) -> Ran:
    """A robot that walks, a mistake at 0.2 s, and another tree at 0.5 s, which is edited once more."""
    root = make_project(tmp_path_factory.mktemp("watched") / "project")
    edits = edited(root, (10, BROKEN), (25, ONCE), (160, ONCE + "# again\n"), (200, "end"))
    return watched(root, WALK, edits, duration=12.0)


@pytest.mark.trials
@shows("reload-mistake")
def test_a_mistake_leaves_the_old_tree_running(swapped: Ran) -> None:
    first, second = swapped.report.reloads[:2]
    assert (first.outcome, second.outcome) == ("refused", "reloaded")
    changes = [c for c in swapped.report.timeline if c["path"].endswith("/walk")]
    assert [c["status"] for c in changes] == ["RUNNING", "INVALID"]
    assert changes[1]["time"] == second.time


@shows("reload-halt", "reason-replaced")
def test_the_old_tree_is_halted(swapped: Ran) -> None:
    halted = [c["path"] for c in swapped.report.timeline if c["feedback"] == "halted: replaced by an edited tree"]
    assert halted[:2] == ["mine/emergency_stop/walk", "mine/emergency_stop"]


@shows("reload-stand")
def test_the_new_tree_starts_when_the_robot_stands(swapped: Ran) -> None:
    swap = swapped.report.reloads[1].time
    assert swap + 0.3 < started(swapped, "wait")[0] < swap + 5  # it walked


@shows("reload-anew")
def test_the_new_tree_starts_from_nothing(swapped: Ran) -> None:
    conditions = [c["status"] for c in swapped.report.timeline if c["path"].endswith("/condition")]
    assert len(started(swapped, "wait")) == 2
    assert "FAILURE" not in conditions  # n is 1 again, counted anew by a new once


@shows("reload-end")
def test_after_its_end_the_robot_waits_for_an_edit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    give_up = "format: 1\nroot: {emergency_stop: give_up}\n"
    root = make_project(tmp_path / "project")
    waits = watched(root, give_up, edited(root), duration=0.5)
    assert (waits.report.exit_code, waits.report.sim_time) == (1, pytest.approx(0.5))
