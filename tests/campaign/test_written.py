"""What a campaign writes: a journal on a disk that is full, a report of requirements."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

from humanoid_bt.campaign.journal import Journal, Unwritable
from humanoid_bt.campaign.report_markdown import markdown
from humanoid_bt.campaign.requirement import Verdict
from humanoid_bt.campaign.summary import Summary
from tests.campaign.conftest import table_of


def test_a_requirement_is_code_in_markdown() -> None:
    said = Summary(table_of(lambda _: True), {})
    text = markdown(said, [Verdict("time_p95 < 20 s", True, "time_p95 is 10 s")], Path("runs/a"))
    assert "✓ `time_p95 < 20 s`: time_p95 is 10 s" in text


def test_a_disk_that_says_at_the_end_that_it_is_full_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(_file: int) -> None:
        raise OSError(errno.EDQUOT, os.strerror(errno.EDQUOT))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(Unwritable, match="cannot be written: Disk quota exceeded"), Journal(tmp_path / "j") as journal:
        journal.add(0, {"a": 1})
