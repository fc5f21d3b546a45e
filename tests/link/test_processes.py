from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from humanoid_bt.link import processes as module
from humanoid_bt.link.processes import ProcessIdentity, current
from tests.link.conftest import Start, first_line


def test_this_process_lives_and_one_with_another_start_does_not() -> None:
    assert current().pid == os.getpid()
    assert current().alive
    assert current().started
    assert not replace(current(), started="1").alive


def test_a_zombie_is_dead(folder: Path, start: Start) -> None:
    process = start("own_run", folder / "runs")
    first_line(process)
    identity = ProcessIdentity.of(process.pid)
    assert identity.alive
    process.kill()
    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)  # ended, but not taken note of
    assert not identity.alive
    process.wait()
    assert not identity.alive


def test_what_cannot_be_known_counts_as_alive() -> None:
    assert replace(current(), pid=2**22 + 1, namespace="pid:[1]").alive
    assert replace(current(), started="").alive


def test_no_process_has_such_an_id() -> None:
    assert not replace(current(), pid=0).alive
    assert not replace(current(), pid=-1).alive
    assert not ProcessIdentity.of(2**22 + 1).alive


def test_start_times_come_from_ps_where_there_is_no_proc(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(module, "_PROC", tmp_path)
    monkeypatch.setattr(module, "_PROC_STAT", False)
    ps = tmp_path / "ps"
    ps.write_text('#!/bin/sh\necho "S    Mon Jan  5 10:00:00 2026"\n')
    ps.chmod(0o700)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    assert current() == ProcessIdentity(os.getpid(), "Mon Jan  5 10:00:00 2026", "")
    assert current().alive
    assert not replace(current(), started="Mon Jan  5 09:00:00 2026").alive
    monkeypatch.setenv("PATH", str(tmp_path / "none"))
    assert current() == ProcessIdentity(os.getpid(), "", "")
    assert current().alive
