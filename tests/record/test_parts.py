"""A recording in several files: each can be opened alone, and all of them are one recording."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any, NoReturn

import numpy as np
import pytest
import rerun as rr

from humanoid_bt.control.cycle_log import Layout
from humanoid_bt.core.errors import UserError
from humanoid_bt.core.messages import FootPose, Level
from humanoid_bt.record import parted_file
from humanoid_bt.record import recorder as recorder_module
from humanoid_bt.record.feed import Feed
from humanoid_bt.record.parted_file import PartedFile
from humanoid_bt.record.parts import MAGIC, first_of, is_recording, part_of, parts_of
from humanoid_bt.record.reading import files_of, read_cycles, read_flight
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.recording_file import RecordingFile
from humanoid_bt.record.sinks import Sinks
from tests.record.conftest import JOINTS
from tests.record.helpers import entities, events, make_state, make_track, rows

Maker = Callable[..., Recorder]
LAYOUT = Layout.of(JOINTS)
STEPS = (("left", FootPose(0.2, 0.1, 0.0)),)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


@pytest.fixture(autouse=True)
def batches_of_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder_module, "_LOCKSTEP_BATCH", 1.0)


def tick(recorder: Recorder, number: int) -> None:
    tracks = {"ball": make_track("ball", position=(1.0, 0.0, 1.0), confidence=1.0, age=0.0)}
    recorder.sample(make_state(0.02 * number, footsteps=STEPS), tracks, {"ball": np.array([1.0, 0.0, 1.0])})
    counts = np.arange(20.0 * number, 20.0 * (number + 1))
    recorder.cycles(np.tile(counts[:4, None], LAYOUT.plan.width), np.tile(counts[:, None], LAYOUT.cycle.width))


def record_parts(record: Maker, file: Path, ticks: int = 160, part_size: int = 1) -> list[tuple[Level, str]]:
    """Record so that every batch, of one second, is a part; return what was told."""
    told: list[tuple[Level, str]] = []
    sinks = Sinks(file, part_size=part_size)
    with record(sinks=sinks, tell=lambda level, text: told.append((level, text))) as recorder:
        recorder.node_changed(0.0, "root/reach", "RUNNING", "on its way")
        for number in range(ticks):
            tick(recorder, number)
        recorder.node_changed(0.02 * ticks, "root/reach", "SUCCESS", "there")
    return told


def static(path: Path) -> dict[str, set[str]]:
    """Return the static components of each entity of a file."""
    found: dict[str, set[str]] = {}
    for chunk in rr.chunk.RrdReader(path).stream():
        if chunk.is_static and not chunk.entity_path.startswith("/__"):
            found.setdefault(chunk.entity_path, set()).update(chunk.to_record_batch().schema.names)
    return found


def test_a_small_recording_is_one_file(record: Maker, file: Path) -> None:
    assert record_parts(record, file, part_size=10_000_000) == []
    assert parts_of(file) == [file]


def test_each_part_can_be_opened_alone(record: Maker, file: Path) -> None:
    told = record_parts(record, file)
    assert [part.name for part in parts_of(file)] == ["run.rrd", *(f"run.part00{number}.rrd" for number in (2, 3, 4))]
    assert [level for level, _ in told] == ["info"] * 3
    assert told[0][1] == f"the recording goes on in '{file.with_name('run.part002.rrd')}'"
    whole = static(file)
    assert {"/flight", "/world/robot/pelvis/belly", "/world/percepts/ball", "/tree/boxes"} <= set(whole)
    for part in parts_of(file):
        assert static(part) == whole
        assert len(rr.chunk.RrdReader(part).blueprints()) == 1
        assert "root: {selector: []}" in rows(part, "/documents/tree", "TextDocument:text")[0][1][0]


def test_a_part_begins_with_what_holds(record: Maker, file: Path) -> None:
    record_parts(record, file)
    first, second, *_ = parts_of(file)
    (lane,) = (entity for entity in entities(first) if entity.endswith("reach") and entity.startswith("/actions"))
    began = rows(second, "/documents/run", "TextDocument:text")[0][0]
    assert began == pytest.approx(1.0)
    assert rows(second, lane, "StateChange:state")[0] == (began, ["RUNNING"])
    assert rows(second, "/world/footsteps", "Boxes3D:centers")[0][0] == began
    (_, labels), *_ = rows(second, "/tree/labels", "Points2D:labels")
    assert any("reach" in label for label in labels)
    at, colors = rows(second, "/world/scene/object_ball/ball", "Ellipsoids3D:colors")[0]
    assert (at, colors) == (began, rows(first, "/world/scene/object_ball/ball", "Ellipsoids3D:colors")[0][1])


def test_all_parts_are_one_recording(record: Maker, file: Path) -> None:
    record_parts(record, file)
    readers = [rr.chunk.RrdReader(part) for part in parts_of(file)]
    ids = {(entry.application_id, entry.recording_id) for reader in readers for entry in reader.recordings()}
    assert len(ids) == 1
    started = [rows(part, "/__properties", "RecordingInfo:start_time") for part in parts_of(file)]
    assert started == [started[0]] * 4
    samples = [time for part in parts_of(file) for time, _ in rows(part, "/robot/speed", "Scalars:scalars")]
    assert samples == pytest.approx([0.02 * number for number in range(160)])
    assert [text for part in parts_of(file) for _, _, text in events(part)] == ["▶ reach: on its way", "✓ reach: there"]


def test_servo_cycles_are_read_from_all_parts_whichever_is_given(record: Maker, file: Path) -> None:
    record_parts(record, file)
    for part in parts_of(file):
        assert read_cycles(part).columns["servo"][:, 0].tolist() == list(range(3200))
    part_of(file, 9).touch()  # of a recorder that was killed before it could write anything
    assert len(read_cycles(file).time) == 3200
    assert read_flight(file).missing == []
    parts_of(file)[1].unlink()
    assert len(read_cycles(file).time) == 2200
    assert read_flight(file).missing == [2]


def test_who_watches_does_not_notice(record: Maker, file: Path, tmp_path: Path) -> None:
    with record(sinks=Sinks(file, part_size=1)) as recorder, rr.RecordingStream("viewer") as viewer:
        viewer.save(tmp_path / "viewer.rrd")
        recorder._outlet.stream.add(viewer)
        recorder.node_changed(0.0, "root/reach", "RUNNING", "")
        for number in range(160):
            tick(recorder, number)
        recorder.flush()
        viewer.flush()
    assert len(parts_of(file)) > 3
    assert len(rows(tmp_path / "viewer.rrd", "/robot/speed", "Scalars:scalars")) == 160
    assert len(rows(tmp_path / "viewer.rrd", "/documents/run", "TextDocument:text")) == 1
    assert len(rows(tmp_path / "viewer.rrd", "/world/footsteps", "Boxes3D:centers")) == 1


@pytest.mark.filterwarnings("ignore:RRD file has no footer")
def test_at_every_moment_all_parts_can_be_read(record: Maker, file: Path, tmp_path: Path) -> None:
    """What a copy holds now is what is left when everything is killed now."""
    with record(sinks=Sinks(file, part_size=1)) as recorder:
        for number in range(160):
            tick(recorder, number)
            if number % 50 == 1:
                left = tmp_path / f"left{number}"
                left.mkdir()
                for part in parts_of(file):
                    shutil.copy(part, left)
                seen = [list(rr.chunk.RrdReader(part).stream()) for part in parts_of(left / "run.rrd")]
                assert all(seen)
                assert len(read_cycles(left / "run.rrd").time) == 20 * (number - 1)


def test_an_overwritten_recording_leaves_no_parts(record: Maker, file: Path) -> None:
    record_parts(record, file)
    notes = part_of(file, 7)
    notes.write_text("no recording")
    other = file.with_name("run.part002.txt")
    other.touch()
    record_parts(record, file, ticks=10)
    assert parts_of(file) == [file, notes]
    assert other.exists()


def test_a_part_that_cannot_be_opened_is_told_once_and_the_recording_goes_on(record: Maker, file: Path) -> None:
    part_of(file, 2).mkdir()
    told = record_parts(record, file)
    assert told == [
        (
            "warning",
            f"the recording '{part_of(file, 2)}' cannot be written: Is a directory: '{file}' becomes larger instead",
        )
    ]
    part_of(file, 2).rmdir()
    assert len(read_cycles(file).time) == 3200


def refused(_path: Path) -> NoReturn:
    raise UserError("the recording cannot be opened: Failed to encode LogMsg")


def never_back(_path: Path) -> None:
    Event().wait()


class Written:
    """A stream whose beginning stands in its file."""

    def __init__(self, path: Path) -> None:
        path.write_bytes(MAGIC)

    def flush(self, timeout_sec: float) -> None:
        pass


class Unwritten:
    """A stream whose beginning does not come into its file."""

    def __init__(self, _path: Path) -> None:
        pass

    def flush(self, timeout_sec: float) -> NoReturn:
        raise RuntimeError("Flush timed out - not all log messages were sent")


NO_ROOM = pytest.mark.parametrize("library", [refused, never_back, Unwritten])


def fill_the_disk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Leave no room, and the library little time."""
    monkeypatch.setattr(RecordingFile, "refusal", lambda _: "No space left on device")
    monkeypatch.setattr(parted_file, "FLUSH_TIMEOUT", 0.05)


@NO_ROOM
def test_a_file_for_which_the_disk_has_no_room_is_told_and_not_left(
    library: Callable[[Path], Any], file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    fill_the_disk(monkeypatch)
    with pytest.raises(UserError) as raised:
        PartedFile(file, 1e9, Feed(), library)
    assert raised.value.problems[0].message == f"the recording '{file}' cannot be written: No space left on device"
    assert not file.exists()


@NO_ROOM
def test_where_the_next_part_has_no_room_this_one_goes_on(
    library: Callable[[Path], Any], file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    parts = PartedFile(
        file,
        1.0,
        Feed(),
        lambda path: (Written if path == file else library)(path),
        lambda _, text: told.append(text),
    )
    parts.settle()
    fill_the_disk(monkeypatch)
    assert not parts.go_on(1.0)
    second = part_of(file, 2)
    assert told == [
        f"the recording '{second}' cannot be written: No space left on device: '{file}' becomes larger instead"
    ]
    assert not second.exists()
    assert not parts.trouble


def test_a_slow_disk_keeps_nobody_from_recording(file: Path) -> None:
    assert not PartedFile(file, 1e9, Feed(), Unwritten).trouble


def test_a_file_that_is_never_opened_is_not_waited_for(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parted_file, "FLUSH_TIMEOUT", 0.05)
    with pytest.raises(UserError, match="cannot be written: nothing can be written there"):
        PartedFile(file, 1e9, Feed(), never_back)


def test_a_part_that_is_deleted_loses_what_was_in_it(record: Maker, file: Path) -> None:
    with record(sinks=Sinks(file, part_size=1)) as recorder:
        for number in range(60):
            tick(recorder, number)
        assert recorder.written == pytest.approx(1.0)
        parts_of(file)[1].unlink()
    assert recorder.written == pytest.approx(1.0)
    assert "was deleted while it was written" in recorder.trouble


def test_a_link_leads_to_all_parts(record: Maker, file: Path, tmp_path: Path) -> None:
    record_parts(record, file)
    link = tmp_path / "elsewhere" / "latest.rrd"
    link.parent.mkdir()
    link.symlink_to(file)
    assert files_of(link) == parts_of(file)
    circle = tmp_path / "circle.rrd"
    circle.symlink_to(circle)
    assert files_of(circle) == [circle]


def test_names_of_parts() -> None:
    file = Path("runs/fetch-20260101-120000.rrd")
    assert part_of(file, 1) == file
    assert part_of(file, 12).name == "fetch-20260101-120000.part012.rrd"
    assert first_of(part_of(file, 1200)) == file
    assert first_of(Path("my.part2.rrd")) == Path("my.part2.rrd")


def test_a_link_is_no_recording(record: Maker, file: Path, tmp_path: Path) -> None:
    record().close()
    link = tmp_path / "link.rrd"
    link.symlink_to(file)
    assert (is_recording(file), is_recording(link), is_recording(tmp_path)) == (True, False, False)
