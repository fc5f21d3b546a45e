from __future__ import annotations

from pathlib import Path

import pytest

from tests.projects import make_project


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A user's project folder."""
    return make_project(tmp_path_factory.mktemp("user") / "project")


@pytest.fixture
def in_project(project: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Go to the user's project folder."""
    monkeypatch.chdir(project)
