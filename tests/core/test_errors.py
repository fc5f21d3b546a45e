from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.core.errors import relative


def test_a_path_is_told_as_seen_from_here_and_a_link_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.symlink_to(here)
    monkeypatch.chdir(here)
    for name, leads in (("dangling", tmp_path / "nowhere"), ("file", here / "other")):
        (here / name).symlink_to(leads)
        assert relative(Path(name)) == relative(here / name) == name
    assert relative(there / "mine") == relative(Path("..") / "here" / "mine") == "mine"
    assert relative(tmp_path / "elsewhere") == str(tmp_path / "elsewhere")
