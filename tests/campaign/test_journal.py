from __future__ import annotations

import errno
import math
import os
import subprocess
import sys
from pathlib import Path

import pytest

from humanoid_bt.campaign.journal import Journal, Unwritable, read_journal
from humanoid_bt.core.errors import UserError


def test_what_is_written_is_there_again(tmp_path: Path) -> None:
    with Journal(tmp_path / "j") as journal:
        journal.add(3, {"a": 1})
        journal.add(1, {"a": 2})
    with Journal(tmp_path / "j") as journal:
        assert journal.entries == {3: {"a": 1}, 1: {"a": 2}}
    assert read_journal(tmp_path / "j") == {3: {"a": 1}, 1: {"a": 2}}


def test_a_line_that_a_kill_tore_is_cut_off(tmp_path: Path) -> None:
    with Journal(tmp_path / "j") as journal:
        journal.add(0, {"a": 1})
        journal.add(1, {"a": 2})
    whole = (tmp_path / "j").read_bytes()
    for cut in range(1, len(whole) // 2):
        (tmp_path / "j").write_bytes(whole[:-cut])
        assert read_journal(tmp_path / "j") == {0: {"a": 1}}
        with Journal(tmp_path / "j") as journal:
            assert journal.entries == {0: {"a": 1}}
            journal.add(1, {"a": 2})
        assert (tmp_path / "j").read_bytes() == whole


def test_nothing_is_written_twice(tmp_path: Path) -> None:
    with Journal(tmp_path / "j") as journal:
        journal.add(0, {})
        with pytest.raises(ValueError, match="already"):
            journal.add(0, {})


def test_two_do_not_write_at_once(tmp_path: Path) -> None:
    with Journal(tmp_path / "j"), pytest.raises(UserError, match="writes to"):
        Journal(tmp_path / "j")
    Journal(tmp_path / "j").close()


@pytest.mark.parametrize("text", ["what\nelse\n", "[]\n", "1\n", '{"trial":[]}\n', '{"number":1}\n'])
def test_another_file_is_no_journal(tmp_path: Path, text: str) -> None:
    (tmp_path / "j").write_text(text)
    for read in (Journal, read_journal):
        with pytest.raises(UserError, match="no journal"):
            read(tmp_path / "j")
    assert (tmp_path / "j").read_text() == text


def test_what_is_no_json_is_not_written(tmp_path: Path) -> None:
    with Journal(tmp_path / "j") as journal, pytest.raises(ValueError, match="not JSON compliant"):
        journal.add(0, {"a": math.nan})
    assert (tmp_path / "j").read_bytes() == b""


def test_of_two_lines_of_one_number_the_first_counts(tmp_path: Path) -> None:
    (tmp_path / "j").write_text('{"trial":0,"a":1}\n{"trial":0,"a":2}\n')
    with Journal(tmp_path / "j") as journal:
        assert journal.entries == read_journal(tmp_path / "j") == {0: {"a": 1}}


def test_a_disk_that_takes_a_part_of_a_line_takes_it_whole_or_not_at_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, room = os.write, 60

    def nearly_full(file: int, data: bytes) -> int:
        nonlocal room
        if not room:
            raise OSError(errno.ENOSPC, "No space left on device")
        taken = write(file, data[: min(7, room)])
        room -= taken
        return taken

    with Journal(tmp_path / "j") as journal:
        monkeypatch.setattr(os, "write", nearly_full)
        journal.add(0, {"a": "long enough"})
        with pytest.raises(Unwritable, match="No space left on device"):
            journal.add(1, {"a": "long enough" * 5})
        assert (tmp_path / "j").read_text() == '{"trial":0,"a":"long enough"}\n'
        assert list(journal.entries) == [0]


_FULL = """
import resource, signal, sys
from pathlib import Path
from humanoid_bt.campaign.journal import Journal, Unwritable
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
journal = Journal(Path(sys.argv[1]))
try:
    for number in range(100):
        journal.add(number, {"text": "x" * 50})
except Unwritable as error:
    print(number, error)
"""


def test_a_full_disk_keeps_what_is_there(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", _FULL, "j"], cwd=tmp_path, capture_output=True, text=True, check=True, env={**os.environ}
    )
    number, _, message = done.stdout.partition(" ")
    assert "'j' cannot be written: File too large" in message
    assert (tmp_path / "j").read_bytes().endswith(b"}\n")  # a part of a line is taken back
    with Journal(tmp_path / "j") as journal:
        assert list(journal.entries) == list(range(int(number)))
        assert len(journal.entries) > 5


def test_a_disk_that_says_at_the_end_that_it_is_full_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_file: int) -> None:
        raise OSError(errno.EDQUOT, os.strerror(errno.EDQUOT))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(Unwritable, match="cannot be written: Disk quota exceeded"), Journal(tmp_path / "j") as journal:
        journal.add(0, {"a": 1})
