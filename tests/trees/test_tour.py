"""The demo tree ``tour``: the library's trees together."""

from pathlib import Path

import pytest

from tests.session.helpers import ran
from tests.trees.conftest import ended


@pytest.mark.trials
def test_receives_the_visitor_once_and_walks_on(tmp_path: Path) -> None:
    run = ran("tour", tmp_path, duration=90)
    assert run.report.outcome == "success", run.report.reason
    assert not run.report.stops
    assert ended(run, "walk_to") == ["success", "success"]
    assert ended(run, "wave") == ["success"]
    assert ended(run, "offer") == []  # ended by what was waited for
    assert ended(run, "step_back") == ["success"]
