from __future__ import annotations

import os
from pathlib import Path

import pytest

from humanoid_bt.link.heartbeat import Heartbeat
from humanoid_bt.link.segment import HEADER, Kind, LinkError, Segment


def test_what_others_can_reach_is_refused(folder: Path) -> None:
    Heartbeat.create(folder / "beat").close()
    (folder / "beat").chmod(0o640)
    with pytest.raises(LinkError, match=r"not a private file of this user \(owner \d+, mode 640\)"):
        Heartbeat.open(folder / "beat")


def test_what_another_user_made_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    Heartbeat.create(folder / "beat").close()
    stranger = os.geteuid() + 1
    monkeypatch.setattr(os, "geteuid", lambda: stranger)
    with pytest.raises(LinkError, match="not a private file of this user"):
        Heartbeat.open(folder / "beat")


def test_links_folders_and_pipes_are_refused(folder: Path) -> None:
    Heartbeat.create(folder / "beat").close()
    (folder / "link").symlink_to(folder / "beat")
    (folder / "folder").mkdir(mode=0o700)
    os.mkfifo(folder / "pipe", 0o600)
    for name in ("link", "folder", "pipe"):
        with pytest.raises(LinkError):
            Heartbeat.open(folder / name)


def test_a_reader_cannot_write(folder: Path) -> None:
    Segment.create(folder / "ring", Kind.RING, 2 * HEADER).close()
    segment = Segment.open(folder / "ring", Kind.RING, write=False)
    with pytest.raises(TypeError):
        segment.words[0] = 1


def test_a_folder_that_is_not_there_is_said_so(folder: Path) -> None:
    with pytest.raises(LinkError, match="cannot be made: No such file"):
        Heartbeat.create(folder / "none" / "beat")
