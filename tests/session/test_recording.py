"""What becomes of a run's recording when something goes wrong with it: it is told, and the run goes on."""

from __future__ import annotations

import json
import resource
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.errors import UserError
from humanoid_bt.record import remote_recorder
from humanoid_bt.record.parts import MAGIC
from humanoid_bt.record.reading import read_cycles, read_flight
from humanoid_bt.session import options
from humanoid_bt.session.report import Report
from humanoid_bt.session.run import run
from humanoid_bt.session.session import Session
from tests.record.helpers import events
from tests.session.helpers import last_time

LENGTH = 3.0  # s of a run


def recorder_of(session: Session) -> subprocess.Popen[bytes]:
    """Return the process that records."""
    recorder = session._drive._recorder
    assert recorder is not None
    return recorder._process


def harmed(project: Path, file: Path, harm: Callable[[Session], object], at: float = 1.5) -> Report:
    """Return the report of a run to whose recording something is done."""
    with Session("stand", workspace=project, record=file, camera=False, duration=LENGTH) as session:
        session.run_until(at)
        harm(session)
        session.run_until(LENGTH)
    assert session.report.outcome == "unfinished"
    assert session.report.stops == []
    return session.report


def errors(report: Report) -> list[tuple[float, str]]:
    return [(event["time"], event["text"]) for event in report.events if event["level"] == "error"]


@pytest.mark.trials
def test_a_run_without_trouble_lacks_nothing(project: Path, tmp_path: Path) -> None:
    report = harmed(project, tmp_path / "run.rrd", lambda _session: None)
    assert report.recording_missing == 0.0
    assert errors(report) == []
    assert ("recording", str(tmp_path / "run.rrd")) in report.summary
    assert last_time(tmp_path / "run.rrd") >= LENGTH


def test_a_recorder_that_is_killed_is_told_at_once(project: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"

    def harm(session: Session) -> None:
        recorder = session._drive._recorder
        assert recorder is not None
        assert select.select([recorder._end], [], [], 60.0)[0]  # what it has said before is heard with its end
        recorder_of(session).kill()
        recorder_of(session).wait()

    report = harmed(project, file, harm)
    (at, text), (_, missing) = errors(report)
    assert at == pytest.approx(1.52)
    assert text == "the recorder process ended (killed by signal 9): nothing is recorded from 1.52 s on"
    assert report.recording_missing > LENGTH - 1.5
    assert missing.startswith(f"{report.recording_missing:.1f} s of ")
    assert ("recording", f"{file}  ({report.recording_missing:.1f} s are missing)") in report.summary


@pytest.mark.trials
def test_a_recorder_that_hangs_is_waited_for_but_not_for_ever(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote_recorder, "_PATIENCE", 0.3)
    report = harmed(  # a robot that stands ends soon: what still comes has room on its way to the recorder
        project, tmp_path / "run.rrd", lambda session: recorder_of(session).send_signal(signal.SIGSTOP), 2.98
    )
    (_, text), (_, missing) = errors(report)
    assert text == "the recorder was ended: it took more than 0.3 s to read what it was given"
    assert missing.endswith("are missing in the recording")
    assert report.recording_missing > 0


@pytest.mark.trials
def test_a_recorder_that_takes_nothing_is_given_up_in_the_midst_of_a_run(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote_recorder, "_PATIENCE", 0.3)

    def harm(session: Session) -> None:
        recorder_of(session).send_signal(signal.SIGSTOP)
        recorder = session._drive._recorder
        assert recorder is not None
        while not recorder._over:  # as many lines as the system takes
            recorder.event(1.5, "info", "a line " * 1000)

    report = harmed(project, tmp_path / "run.rrd", harm)
    assert errors(report)[0][1].startswith("the recorder took nothing for 0.3 s and was ended: nothing is recorded")


@pytest.mark.trials
@pytest.mark.parametrize("folder", [False, pytest.param(True, marks=pytest.mark.trials)])
def test_a_recording_that_is_deleted_is_told(project: Path, tmp_path: Path, folder: bool) -> None:
    file = tmp_path / "mine" / "run.rrd"
    file.parent.mkdir()

    def harm(_session: Session) -> None:
        file.unlink()
        if folder:
            file.parent.rmdir()

    report = harmed(project, file, harm)
    (at, text), (_, missing) = errors(report)
    assert 1.5 < at <= LENGTH + 0.1
    assert text == f"the recording '{file}' was deleted while it was written"
    assert report.recording_missing >= LENGTH
    assert (
        missing == f"{report.recording_missing:.1f} s of {report.recording_missing:.1f} s are missing in the recording"
    )


@pytest.fixture
def small_files(project: Path, tmp_path: Path) -> Iterator[int]:
    """Let no file grow beyond some bytes: a recording's beginning, and little of what follows."""
    short = tmp_path / "short.rrd"
    with Session("stand", workspace=project, record=short, camera=False) as session:
        session.run_until(1.02)
        recorder = session._drive._recorder
        assert recorder is not None
        while recorder._written < 1.0:
            recorder._follow()
        limit = short.stat().st_size
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, before[1]))
    yield limit
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.trials
def test_a_recording_that_cannot_grow_is_told(project: Path, tmp_path: Path, small_files: int) -> None:
    file = tmp_path / "run.rrd"
    report = harmed(project, file, lambda _session: None)
    (_, text), _ = errors(report)
    assert text == f"the recording '{file}' is cut short: files may have {small_files} bytes at most here (ulimit -f)"
    assert report.recording_missing > LENGTH - 1.1


_KILLED = """
import os, signal, sys
from humanoid_bt import Session

with Session("walk", workspace=sys.argv[1], record=sys.argv[2], camera=False) as session:
    session.run_until(1.5)
    print("rerun" in sys.modules, flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
"""


def test_a_program_that_is_killed_leaves_a_whole_recording_and_no_process(project: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"
    done = subprocess.run(  # comes back when both have ended: the recorder has the same standard error
        [sys.executable, "-c", _KILLED, project, file], capture_output=True, text=True, check=False, timeout=30
    )
    assert done.returncode == -signal.SIGKILL
    assert done.stdout.strip() == "False"  # it is the recorder that imports it
    assert last_time(file) == pytest.approx(1.5)
    assert events(file)[-1][2] == "the process of the run ended without closing the recording"


def test_a_session_that_is_never_entered_leaves_no_process(project: Path) -> None:
    session = Session("walk", workspace=project, record=True)
    process = recorder_of(session)
    del session
    assert process.poll() == -signal.SIGKILL


@pytest.mark.trials
def test_two_runs_of_the_same_second_have_recordings_of_their_own(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(options, "default_recording", lambda _tree: Path("runs/walk.rrd"))
    sessions = [Session("stand", workspace=project, record=True, camera=False, duration=0.1) for _ in range(2)]
    for session in sessions:
        session.start()
    for session in sessions:
        session.run_until(1.0)
        session.close()
    names = [str(session.report.recording) for session in sessions]
    assert names == ["runs/walk.rrd", "runs/walk-2.rrd"]
    assert [last_time(Path(name)) > 0.05 for name in names] == [True] * 2


@pytest.mark.trials
def test_two_runs_cannot_write_one_file(project: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.rrd"
    with Session("stand", workspace=project, record=file, camera=False) as first:
        first.run_until(0.1)
        with pytest.raises(UserError, match=r"run\.rrd' is being written by another run"):
            Session("stand", workspace=project, record=file).start()
    assert last_time(file) > 0.05


def test_a_run_that_begins_removes_old_recordings_and_tells_it(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    runs = tmp_path / "runs"
    runs.mkdir()
    (runs / "limits.yaml").write_text("recordings: 2\n")
    for number in range(3):
        (runs / f"walk-20260101-12000{number}.rrd").write_bytes(MAGIC)
    report = run("walk", workspace=project, record=True, camera=False, duration=0.1)
    (told,) = (event for event in report.events if "removed" in event["text"])
    assert told["text"] == "2 old recordings were removed, 8 B: walk-20260101-120000.rrd, walk-20260101-120001.rrd"
    assert told["level"] == "info"
    assert report.recording is not None
    assert report.recording_parts == [report.recording]
    stem = Path(report.recording).stem
    left = sorted(path.name for path in runs.iterdir())
    assert left == ["limits.yaml", "walk-20260101-120002.rrd", f"{stem}.json", f"{stem}.rrd"]
    assert json.loads((runs / f"{stem}.json").read_text())["outcome"] == "unfinished"


@pytest.mark.trials
def test_a_recording_that_was_named_removes_nothing(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "limits.yaml").write_text("recordings: 1\n")
    for number in range(3):
        (tmp_path / "runs" / f"walk-20260101-12000{number}.rrd").write_bytes(MAGIC)
    run("walk", workspace=project, record="runs/mine.rrd", camera=False, duration=0.1)
    assert len(list((tmp_path / "runs").iterdir())) == 5


def test_mistakes_in_the_limits_are_told_before_the_run(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    (tmp_path / "runs" / "limits.yaml").write_text("size: 20\n")
    with pytest.raises(UserError, match=r"runs/limits\.yaml:1:7"):
        Session("walk", workspace=project, record=True)
    Session("walk", workspace=project)


@pytest.mark.trials
def test_a_long_recording_is_in_several_files(project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(options, "SMALLEST_PART", 1)
    file = tmp_path / "run.rrd"
    report = run("walk", workspace=project, record=file, record_part_size="1 MB", camera=False, duration=5.5)
    assert report.recording == str(file)
    first, second, *others = report.recording_parts
    assert (first, second) == (str(file), str(tmp_path / "run.part002.rrd"))
    assert report.recording_missing == 0.0
    assert ("recording", f"{file}, in {2 + len(others)} parts") in report.summary
    told = [event["text"] for event in report.events if "goes on" in event["text"]]
    assert told == [f"the recording goes on in '{part}'" for part in (second, *others)]
    cycles = read_cycles(file)
    assert np.diff(cycles.time) == pytest.approx(1e-3)
    assert cycles.time[-1] >= 1.1


@pytest.mark.parametrize("size", [0, -1, 1.5, True, "5", "5 MB", "many", None, 9_999_999])
def test_a_part_has_a_size(project: Path, size: Any) -> None:
    with pytest.raises(UserError, match=r"'record_part_size' must be a size such as .*, at least 10\.0 MB, not"):
        Session("walk", workspace=project, record_part_size=size)


@pytest.mark.realtime
def test_the_robot_does_not_notice_what_becomes_of_the_recorder(
    project: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote_recorder, "_BEHIND", 0.5)
    file = tmp_path / "run.rrd"
    with Session("walk", workspace=project, mode="realtime", record=file, camera=False) as session:
        session.step()
        begin = session.time  # of control was earlier
        session.run_until(begin + 0.2)
        recorder_of(session).send_signal(signal.SIGSTOP)
        session.run_until(begin + 1.0)
        recorder_of(session).kill()
        session.run_until(begin + 1.3)
    report = session.report
    assert report.stops == []
    behind, killed, missing = [text for _, text in errors(report)]
    assert behind == "the recorder is more than 0.5 s behind: what it cannot take is missing in the recording"
    assert killed.startswith("the recorder process ended (killed by signal 9): nothing is recorded from ")
    assert missing.endswith(" s are missing in the recording")
    assert report.recording_missing > 1.0


@pytest.mark.trials
@pytest.mark.realtime
def test_what_was_handed_over_stands_in_the_file_at_once(project: Path, tmp_path: Path) -> None:
    lost = []
    for number in range(3):
        file = tmp_path / f"run{number}.rrd"
        with Session("walk", workspace=project, mode="realtime", record=file, camera=False) as session:
            session.step()
            session.run_until(session.time + 0.5 + 0.013 * number)
            recorder_of(session).kill()
            recorder_of(session).wait()
            *_, last = read_flight(file).ticks()
            lost.append(session.time - last.state.time)
    assert sorted(lost)[1] < 0.1  # 40 to 60 ms, the last tick itself included; a busy machine takes longer
