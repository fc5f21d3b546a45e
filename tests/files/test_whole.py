"""Files that are written whole or not at all."""

from __future__ import annotations

import os
import stat
import threading
from pathlib import Path

import pytest

from humanoid_bt.files.whole import make_way, write_whole


def test_a_new_file_has_the_permissions_of_new_files(tmp_path: Path) -> None:
    write_whole(tmp_path / "new", b"content")
    (tmp_path / "other").touch()
    assert (tmp_path / "new").read_bytes() == b"content"
    assert (tmp_path / "new").stat().st_mode == (tmp_path / "other").stat().st_mode


@pytest.mark.parametrize("letter", "x漢🤖")
def test_a_name_can_be_as_long_as_names_are(tmp_path: Path, letter: str) -> None:
    name = letter * (255 // len(letter.encode()))
    make_way(tmp_path / name)
    write_whole(tmp_path / name, b"content")
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_a_file_keeps_its_permissions_and_a_link_stays_one(tmp_path: Path) -> None:
    file, link = tmp_path / "file", tmp_path / "link"
    file.write_bytes(b"before")
    file.chmod(0o640)
    link.symlink_to(file)
    write_whole(link, b"after")
    assert link.is_symlink() and file.read_bytes() == b"after"
    assert stat.S_IMODE(file.stat().st_mode) == 0o640


def test_what_fails_on_the_way_leaves_the_old_content_and_nothing_else(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "file"
    file.write_bytes(b"before")

    def full(_descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        write_whole(file, b"after")
    assert file.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [file]


def test_a_pipe_is_written_as_it_is(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    make_way(pipe)
    writing = threading.Thread(target=write_whole, args=(pipe, b"content"))
    writing.start()
    assert pipe.read_bytes() == b"content"
    writing.join()
    assert stat.S_ISFIFO(pipe.stat().st_mode)


def test_what_a_process_has_open_is_not_replaced(tmp_path: Path) -> None:
    with (tmp_path / "out").open("w+b") as file:
        for name in (f"/dev/fd/{file.fileno()}", f"/proc/self/fd/{file.fileno()}"):
            make_way(Path(name))
            write_whole(Path(name), b"content")
            file.seek(0)
            assert file.read() == b"content"


def test_who_makes_way_finds_out_what_will_not_work(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to("loop")
    for nowhere in ("missing/file", "loop", ".", "x" * 300):
        with pytest.raises(OSError):
            make_way(tmp_path / nowhere)
    (tmp_path / "old").touch()
    make_way(tmp_path / "old")
    assert [path.name for path in tmp_path.iterdir()] == ["loop"]
