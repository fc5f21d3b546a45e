"""The demo tree on the simulated robot: it finds its target wherever that is."""

from pathlib import Path

import pytest

from humanoid_bt.session.report import Report
from tests.trees.fetch_trials import fault, trial

pytestmark = pytest.mark.trials


def begins(report: Report) -> dict[str, float]:
    """Return when something first happened to a node, by its name."""
    return {entry["path"].rsplit("/", 1)[-1]: entry["time"] for entry in reversed(report.timeline)}


def test_a_target_in_view_is_touched_without_turning(tmp_path: Path) -> None:
    report = trial(tmp_path, "random_target", 7)
    assert not fault(report)
    assert "turn" not in begins(report)


def test_a_target_behind_is_touched_after_looking_around_and_turning(tmp_path: Path) -> None:
    report = trial(tmp_path, "behind", 1)
    assert not fault(report)
    assert begins(report)["idle"] == 0
    assert begins(report)["turn"] == pytest.approx(9, abs=0.05)
