"""Plugins that tests of the project use, and when its own scenarios are run."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest_plugins = ["pytester"]
_SCENARIOS = Path(__file__).parent / "scenarios"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Keep the scenarios with physics for `make test-trials`."""
    for item in items:
        if item.path.is_relative_to(_SCENARIOS) and not getattr(item, "scenario").dry:  # noqa: B009 (only these have one)
            item.add_marker(pytest.mark.trials)
