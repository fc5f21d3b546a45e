"""Which recording is meant where none is named."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.review.newest import newest_recording


def put(folder: Path, name: str, written: float, text: str = "something") -> Path:
    path = folder / name
    path.write_text(text)
    os.utime(path, (written, written))
    return path


def test_the_one_that_was_written_last_is_meant(tmp_path: Path) -> None:
    put(tmp_path, "b.rrd", 1.0)
    newest = put(tmp_path, "a.rrd", 2.0)
    put(tmp_path, "empty.rrd", 3.0, "")
    put(tmp_path, "a.json", 3.0)
    (tmp_path / "folder.rrd").mkdir()
    (tmp_path / "lost.rrd").symlink_to(tmp_path / "nowhere")  # as one that is removed meanwhile
    assert newest_recording(tmp_path) == newest


def test_a_folder_without_one_says_so(tmp_path: Path) -> None:
    for folder in (tmp_path, tmp_path / "none"):
        with pytest.raises(UserError, match="there is no recording in"):
            newest_recording(folder)


def test_a_folder_that_cannot_be_read_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "iterdir", refuse)
    with pytest.raises(UserError, match="cannot be read: Permission denied"):
        newest_recording(tmp_path)
