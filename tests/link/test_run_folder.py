from __future__ import annotations

import errno
import json
import os
import shutil
import stat
from collections.abc import Callable
from pathlib import Path

import pytest

from humanoid_bt.link import run_folder
from humanoid_bt.link.estop import EStop
from humanoid_bt.link.heartbeat import Heartbeat
from humanoid_bt.link.run_folder import RunFolder, RunInfo, clean_stale, default_root, live_runs
from humanoid_bt.link.segment import LinkError
from tests.link.conftest import Start, first_line

INFO = RunInfo("fetch", "humanoid")


@pytest.fixture
def root(folder: Path) -> Path:
    return folder / "runs"


def test_who_is_interrupted_while_a_run_is_removed_leaves_nothing_behind(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = RunFolder.create(INFO, root)
    rmtree, calls = shutil.rmtree, []

    def pressed(path: Path, ignore_errors: bool) -> None:
        calls.append(path)
        if len(calls) == 1:
            raise KeyboardInterrupt
        rmtree(path, ignore_errors)

    monkeypatch.setattr(shutil, "rmtree", pressed)
    with pytest.raises(KeyboardInterrupt):
        run.close()
    assert [path.name for path in root.iterdir()] == [".lock"]


def test_a_run_says_who_it_is_and_is_gone_when_closed(root: Path) -> None:
    with RunFolder.create(INFO, root) as run:
        info = run.info
        assert (info.tree, info.robot, info.run_id) == ("fetch", "humanoid", run.folder.name)
        assert (info.processes, info.living) == ({"owner": os.getpid()}, {"owner"})
        assert info.alive
        assert info.owner_alive
        assert json.loads((run.folder / "run.json").read_text())["processes"]["owner"] == os.getpid()
        Heartbeat.create(run.path("decision"))
        assert Heartbeat.open(RunFolder.open(run.folder).path("decision")).count == 0
    assert not run.folder.exists()
    assert live_runs(root) == []
    run.close()
    for closed in (lambda: run.info, lambda: run.register("control", 1), lambda: RunFolder.open(run.folder)):
        with pytest.raises(LinkError):
            closed()


def test_folders_and_files_are_private_whatever_the_umask(root: Path) -> None:
    before = os.umask(0)
    try:
        run = RunFolder.create(INFO, root)
        Heartbeat.create(run.path("decision"))
    finally:
        os.umask(before)
    modes = {path.name: stat.S_IMODE(path.stat().st_mode) for path in (root, run.folder, *run.folder.iterdir())}
    private = {"run.json": 0o600, ".life-owner": 0o600, "decision": 0o600}
    assert modes == {"runs": 0o700, run.folder.name: 0o700} | private


@pytest.fixture
def fill(monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Leave no room in memory."""

    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    return lambda: monkeypatch.setattr(run_folder, "_write_meta", full)


def test_a_process_for_whose_name_there_is_no_room_is_told(root: Path, fill: Callable[[], None]) -> None:
    with RunFolder.create(INFO, root) as run:
        fill()
        with pytest.raises(LinkError, match="cannot be written: No space left on device"):
            run.register("control", 1)


def test_a_folder_for_which_there_is_no_room_is_not_left_behind(root: Path, fill: Callable[[], None]) -> None:
    fill()
    with pytest.raises(LinkError, match="cannot be made: No space left on device"):
        RunFolder.create(INFO, root)
    assert [path.name for path in root.iterdir()] == [".lock"]


def test_two_runs_do_not_meet(root: Path) -> None:
    with RunFolder.create(INFO, root) as first, RunFolder.create(RunInfo("wave", "h1"), root) as second:
        assert first.folder != second.folder
        Heartbeat.create(first.path("decision")).beat()
        assert Heartbeat.create(second.path("decision")).count == 0
        assert {info.tree for _, info in live_runs(root)} == {"fetch", "wave"}
        second.close()
        assert [run.folder for run, _ in live_runs(root)] == [first.folder]


def test_names_stay_inside_the_folder(root: Path) -> None:
    with RunFolder.create(INFO, root) as run:
        for name in ("", ".", "..", "../x", "/x", "a/b", ".hidden", "run.json", "a\0b"):
            with pytest.raises(ValueError, match="no file name"):
                run.path(name)


def test_the_folder_of_a_killed_run_is_cleaned_and_no_other(root: Path, start: Start) -> None:
    process = start("own_run", root)
    dead = first_line(process)
    with RunFolder.create(INFO, root) as ours:
        assert [info.run_id for _, info in live_runs(root)] == sorted([dead, ours.folder.name], key=_started(root))
        assert clean_stale(root) == []
        process.kill()
        process.wait()
        assert [run.folder for run, _ in live_runs(root)] == [ours.folder]
        assert clean_stale(root) == [dead]
        assert not (root / dead).exists()
        assert ours.info.alive
        assert clean_stale(root) == []


def _started(root: Path) -> Callable[[str], tuple[float, str]]:
    return lambda run_id: (RunFolder(root / run_id).info.started, run_id)


def test_a_run_lives_as_long_as_any_of_its_processes(root: Path, start: Start) -> None:
    process = start("own_run", root, "helped")
    run = RunFolder.open(root / first_line(process))
    assert run.info.living == {"owner", "control"}
    process.kill()
    process.wait()
    assert not run.info.owner_alive
    assert [info.run_id for _, info in live_runs(root)] == [run.folder.name]
    assert clean_stale(root) == []
    assert process.stdin is not None
    process.stdin.write("\n")  # the helper reads it too, and ends with it
    process.stdin.flush()
    while live_runs(root):
        pass
    assert clean_stale(root) == [run.folder.name]


def test_what_a_dead_owner_forked_is_none_of_its_run(root: Path, start: Start) -> None:
    process = start("fork_in_run", root)
    dead = first_line(process)
    process.wait()
    assert live_runs(root) == []
    assert clean_stale(root) == [dead]


def test_processes_are_told_for_people_and_none_of_it_says_that_they_live(root: Path) -> None:
    with RunFolder.create(INFO, root) as run:
        run.register("control", os.getpid())
        assert run.info.processes == {"owner": os.getpid(), "control": os.getpid()}
        assert run.info.living == {"owner"}
        run.leave()
        assert not run.info.alive  # though a process of that id lives: it may be another container's


def test_a_run_of_another_version_is_left_alone(root: Path, caplog: pytest.LogCaptureFixture) -> None:
    run = RunFolder.create(INFO, root)
    meta = run.folder / "run.json"
    meta.write_text(meta.read_text().replace('"format": 3', '"format": 2'))
    run.leave()
    assert live_runs(root) == clean_stale(root) == []
    assert run.folder.exists()
    assert caplog.text == ""


def test_a_folder_that_was_never_finished_is_cleaned_and_an_unreadable_one_is_left(root: Path) -> None:
    run = RunFolder.create(INFO, root)
    (root / "half").mkdir(mode=0o700)
    (root / "file").touch(mode=0o600)
    (run.folder / "run.json").write_text("{")
    assert clean_stale(root) == ["half"]
    assert live_runs(root) == []
    with pytest.raises(LinkError, match="malformed"):
        RunFolder.open(run.folder)


def test_a_folder_that_lost_its_meta_file_is_left_for_the_e_stop(root: Path) -> None:
    run = RunFolder.create(INFO, root)
    EStop.create(run.path("estop")).close()
    (run.folder / "run.json").unlink()
    assert clean_stale(root) == []
    assert run.path("estop").exists()


def test_what_a_killed_cleaner_left_is_cleaned(root: Path) -> None:
    run = RunFolder.create(INFO, root)
    run.folder.rename(root / f".closed-{run.folder.name}")  # as if killed between renaming and removing
    assert live_runs(root) == []
    assert clean_stale(root) == []
    assert [path.name for path in root.iterdir()] == [".lock"]


def test_a_root_that_is_not_ours_alone_is_refused(root: Path, folder: Path) -> None:
    (folder / "elsewhere").mkdir(mode=0o700)
    root.symlink_to(folder / "elsewhere")
    for use in (lambda: RunFolder.create(INFO, root), lambda: live_runs(root), lambda: clean_stale(root)):
        with pytest.raises(LinkError, match="not a private file"):
            use()
    root.unlink()
    root.mkdir(mode=0o755)
    root.chmod(0o755)
    with pytest.raises(LinkError, match=r"not a private folder of this user \(owner \d+, mode 755\)"):
        RunFolder.create(INFO, root)
    root.chmod(0o700)
    assert list((folder / "elsewhere").iterdir()) == []


@pytest.mark.skipif(os.geteuid() != 0, reason="only root can make what belongs to another user")
@pytest.mark.parametrize("taken", ["folder", "link", "file"])
def test_a_root_that_another_user_has_made_is_made_beside_it_and_found(root: Path, folder: Path, taken: str) -> None:
    foreign = folder / "foreign"
    foreign.mkdir(mode=0o700)
    {"folder": root.mkdir, "link": lambda: root.symlink_to(foreign), "file": root.touch}[taken]()
    (folder / "runs.theirs").mkdir(mode=0o700)
    for path in (root, folder / "runs.theirs", foreign):
        os.chown(path, 12345, 12345, follow_symlinks=False)
    assert live_runs(root) == clean_stale(root) == []
    with RunFolder.create(INFO, root) as one, RunFolder.create(INFO, root) as other:
        home = one.folder.parent
        assert home == other.folder.parent
        assert home.name.startswith("runs.")
        assert stat.S_IMODE(home.stat().st_mode) == 0o700
        assert {run.folder for run, _ in live_runs(root)} == {one.folder, other.folder}
        assert RunFolder.open(one.folder).info.alive
        other.leave()
        assert clean_stale(root) == [other.folder.name]
    assert list(foreign.iterdir()) == []


def test_a_link_inside_the_root_is_neither_joined_nor_followed(root: Path, folder: Path) -> None:
    RunFolder.create(INFO, root).close()
    precious = folder / "precious"
    precious.mkdir(mode=0o700)
    (precious / "thing").touch()
    (root / "run").symlink_to(precious)
    with pytest.raises(LinkError):
        RunFolder.open(root / "run")
    assert clean_stale(root) == []
    assert (precious / "thing").exists()


def test_runs_that_begin_and_clean_at_once_leave_each_other_alone(root: Path, start: Start) -> None:
    processes = [start("churn_runs", root, 25) for _ in range(3)]
    assert [process.wait() for process in processes] == [0, 0, 0]
    assert live_runs(root) == []


def test_without_a_root_there_are_no_runs(root: Path) -> None:
    assert live_runs(root) == []
    assert clean_stale(root) == []
    assert not root.exists()


def test_every_user_has_a_root() -> None:
    assert default_root().name == f"humanoid-bt-{os.geteuid()}"
    assert default_root().parent.is_dir()
