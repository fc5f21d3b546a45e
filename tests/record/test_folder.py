"""The folder of recordings keeps its limits, and loses nothing else."""

from __future__ import annotations

import fcntl
import os
from pathlib import Path

import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.core.sizes import read_size, shown_size
from humanoid_bt.record.folder import make_room, recordings_in
from humanoid_bt.record.folder_limits import FolderLimits, load_limits
from humanoid_bt.record.parts import MAGIC


def put(folder: Path, name: str, size: int = 1000, written: float = 0.0) -> Path:
    """Put a file there that begins as a recording does, and was written last so many seconds after 1970."""
    path = folder / name
    path.write_bytes(MAGIC + bytes(size - len(MAGIC)))
    os.utime(path, (written, written))
    return path


def names(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Return a folder of four recordings, a second apart: with parts, a log and a report, a number, a dotted name."""
    put(tmp_path, "fetch-20260101-120000.rrd")
    put(tmp_path, "fetch-20260101-120000.part002.rrd")
    put(tmp_path, "fetch-20260101-120000.part010.rrd", written=1)
    (tmp_path / "fetch-20260101-120000.control.log").write_text("x" * 10)
    (tmp_path / "fetch-20260101-120000.json").write_text("{}")
    put(tmp_path, "walk-20260101-120001.rrd", written=2)
    put(tmp_path, "fetch-20260101-120001-2.rrd", written=2)
    put(tmp_path, "my.tree-20260101-120002.rrd", written=3)
    return tmp_path


def test_recordings_are_found_newest_first_with_all_their_files(folder: Path) -> None:
    found = recordings_in(folder)
    assert [one.first.stem for one in found] == [
        "my.tree-20260101-120002",
        "walk-20260101-120001",
        "fetch-20260101-120001-2",
        "fetch-20260101-120000",
    ]
    assert [one.tree for one in found] == ["my.tree", "walk", "fetch", "fetch"]
    oldest = found[-1]
    assert [part.name[21:] for part in oldest.parts] == [".rrd", ".part002.rrd", ".part010.rrd"]
    assert oldest.size == 3012
    assert not any(one.kept or one.is_written for one in found)


def test_within_its_limits_nothing_is_removed(folder: Path) -> None:
    before = names(folder)
    assert make_room(folder, FolderLimits(recordings=4, size="6012 B")) == ""
    assert names(folder) == before


def test_the_oldest_goes_first_with_all_its_files(folder: Path) -> None:
    told = make_room(folder, FolderLimits(size="6011 B"))
    assert told == "1 old recording was removed, 3.0 kB: fetch-20260101-120000.rrd"
    assert names(folder) == ["fetch-20260101-120001-2.rrd", "my.tree-20260101-120002.rrd", "walk-20260101-120001.rrd"]


def test_no_more_than_so_many_stay(folder: Path) -> None:
    told = make_room(folder, FolderLimits(recordings=1))
    assert told.startswith("3 old recordings were removed, 5.0 kB: fetch-20260101-120000.rrd, fetch-20260101-120001-2")
    assert names(folder) == ["my.tree-20260101-120002.rrd"]


def test_the_oldest_is_what_was_written_first_whatever_the_clock_there_said(folder: Path) -> None:
    put(folder, "far_west-20260101-060000.rrd", written=4)
    assert recordings_in(folder)[0].tree == "far_west"
    make_room(folder, FolderLimits(recordings=1))
    assert names(folder) == ["far_west-20260101-060000.rrd"]


@pytest.mark.parametrize("suffix", ["mcap", "mp4", "notes.md", "mine.json", "keep.txt"])
def test_what_somebody_made_of_a_recording_stays(folder: Path, suffix: str) -> None:
    made = folder / f"fetch-20260101-120000.{suffix}"
    made.write_text("x" * 5000)
    told = make_room(folder, FolderLimits(recordings=3))
    assert told == "1 old recording was removed, 3.0 kB: fetch-20260101-120000.rrd"
    assert [name for name in names(folder) if name.startswith("fetch-20260101-120000")] == [made.name]


def test_what_is_kept_stays_and_does_not_count(folder: Path) -> None:
    oldest = recordings_in(folder)[-1]
    assert not oldest.keep(True)
    assert recordings_in(folder)[-1].keep(True)
    make_room(folder, FolderLimits(recordings=1))
    left = [one.first.stem for one in recordings_in(folder)]
    assert left == ["my.tree-20260101-120002", "fetch-20260101-120000"]
    assert "fetch-20260101-120000.keep" in names(folder)
    recordings_in(folder)[-1].keep(False)
    make_room(folder, FolderLimits(recordings=1))
    assert names(folder) == ["my.tree-20260101-120002.rrd"]


@pytest.mark.parametrize("part", ["fetch-20260101-120000.rrd", "fetch-20260101-120000.part010.rrd"])
def test_what_is_written_stays(folder: Path, part: str) -> None:
    with (folder / part).open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        assert recordings_in(folder)[-1].is_written
        make_room(folder, FolderLimits(recordings=1))
        assert len(names(folder)) == 5


@pytest.mark.parametrize(
    "name",
    [
        "notes.txt",
        "limits.yaml",
        "mine.rrd",
        "fetch-2026.rrd",
        "fetch-20261399-120000.rrd",
        "fetch-20250101-120000.txt",
        "-20250101-120000.rrd",
        "fetch-20250101-120000.rrd.bak",
        "fetch-20250101-1200000.rrd",
    ],
)
def test_other_files_stay(tmp_path: Path, name: str) -> None:
    put(tmp_path, name)
    put(tmp_path, "walk-20260101-120001.rrd")
    put(tmp_path, "walk-20260101-120002.rrd")
    make_room(tmp_path, FolderLimits(recordings=1, size="1 B"))
    assert names(tmp_path) == [name]


def test_what_has_such_a_name_and_is_no_recording_stays(tmp_path: Path) -> None:
    (tmp_path / "fetch-20250101-120000.rrd").write_text("something else")
    (tmp_path / "fetch-20250101-120001.rrd").touch()
    (tmp_path / "fetch-20250101-120002.rrd").mkdir()
    elsewhere = put(tmp_path, "mine.rrd")
    (tmp_path / "fetch-20250101-120003.rrd").symlink_to(elsewhere)
    before = names(tmp_path)
    assert make_room(tmp_path, FolderLimits(recordings=1, size="1 B")) == ""
    assert names(tmp_path) == before
    put(tmp_path, "fetch-20250101-120000.part002.rrd")
    assert make_room(tmp_path, FolderLimits(size="1 B"))
    assert names(tmp_path) == before


def test_what_cannot_be_removed_is_told(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(self: Path, missing_ok: bool = False) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(Path, "unlink", refuse)
    told = make_room(folder, FolderLimits(recordings=1))
    assert told.endswith("fetch-20260101-120000.rrd' cannot be removed: Permission denied")


def test_a_folder_that_is_not_there_has_no_recordings(tmp_path: Path) -> None:
    assert recordings_in(tmp_path / "runs") == []


def test_limits_are_read_from_the_folder(tmp_path: Path) -> None:
    assert (load_limits(tmp_path).recordings, load_limits(tmp_path).bytes) == (500, 20_000_000_000)
    (tmp_path / "limits.yaml").write_text("recordings: 3\nsize: 1.5 GB\n")
    assert (load_limits(tmp_path).recordings, load_limits(tmp_path).bytes) == (3, 1_500_000_000)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("size: 20\n", r"limits.yaml:1:7"),
        ("size: 20 GiB\n", r"limits.yaml:1:7.*'size' must be a size such as 500 MB or 20 GB, not '20 GiB'"),
        ("size: 0 GB\n", r"limits.yaml:1:7.*must be a size"),
        ("recordings: 0\n", r"limits.yaml:1:13"),
        ("recording: 5\n", r"(?s)limits.yaml:1:1.*did you mean 'recordings'"),
        ("- 1\n", r"limits.yaml:1:1"),
    ],
)
def test_mistakes_in_limits_have_their_place(tmp_path: Path, text: str, told: str) -> None:
    (tmp_path / "limits.yaml").write_text(text)
    with pytest.raises(UserError, match=told):
        load_limits(tmp_path)


@pytest.mark.parametrize(
    ("text", "size"),
    [("500MB", 500_000_000), ("20 GB", 20_000_000_000), ("1.5 kB", 1500), ("7 B", 7), ("0 GB", None), ("-1 MB", None)]
    + [(text, None) for text in ("", "MB", "5", "5 s", "1e999 GB", "many")],
)
def test_sizes_are_read(text: str, size: int | None) -> None:
    assert read_size(text) == size


@pytest.mark.parametrize(
    ("size", "text"),
    [
        *[(0, "0 B"), (999, "999 B"), (1000, "1.0 kB"), (999_499, "999 kB"), (999_960, "1.0 MB")],
        *[(1.34e9, "1.3 GB"), (99.9e9, "99.9 GB"), (150e9, "150 GB"), (20e12, "20.0 TB")],
    ],
)
def test_sizes_are_shown(size: float, text: str) -> None:
    assert shown_size(size) == text
