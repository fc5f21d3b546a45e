"""The reader of recordings' files: what the viewer's library reads of a whole one, and more of a damaged one."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import pytest
import rerun as rr

from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.rrd import RrdFile
from tests.record.helpers import make_state, messages

Maker = Callable[..., Recorder]


@pytest.fixture
def file(record: Maker, tmp_path: Path) -> Path:
    """A recording of three seconds, whose data are in several messages."""
    with record() as recorder:
        for tick in range(150):
            recorder.sample(make_state(0.02 * tick), {}, {})
            recorder.event(0.02 * tick, "info", f"tick {tick}")
            if tick % 50 == 49:
                recorder.flush()
    return tmp_path / "run.rrd"


def found(path: Path, entity: str) -> list[object]:
    return [batch.to_pydict() for batch in RrdFile(path).batches(entity)]


@pytest.mark.parametrize("entity", ["/flight", "/events", "/none"])
def test_it_reads_what_the_library_reads(file: Path, entity: str) -> None:
    chunks = [chunk for chunk in rr.chunk.RrdReader(file).stream() if chunk.entity_path == entity]
    assert found(file, entity) == [chunk.to_record_batch().to_pydict() for chunk in chunks]
    assert bool(chunks) == (entity != "/none")


def test_a_damaged_head_costs_one_message(file: Path, tmp_path: Path) -> None:
    data, path = file.read_bytes(), tmp_path / "broken.rrd"
    everything = found(file, "/flight")
    costs = []
    *begins, last = messages(data)[-60:]
    for begin in begins:
        path.write_bytes(data[: begin + 8] + b"\xff" * 8 + data[begin + 16 :])
        reader = RrdFile(path)
        costs.append(len(everything) - len(list(reader.batches("/flight"))))
        assert (reader.damaged, reader.cut) == (1, "")
    assert set(costs) == {0, 1}
    path.write_bytes(data[: last + 8] + b"\xff" * 8 + data[last + 16 :])
    reader = RrdFile(path)
    list(reader.batches("/flight"))
    assert reader.cut.startswith("it ends within a message")


def test_a_damaged_content_costs_its_message_and_is_counted(file: Path, tmp_path: Path) -> None:
    data, path = file.read_bytes(), tmp_path / "broken.rrd"
    everything = found(file, "/flight")
    costs = set()
    for begin in messages(data)[-60:]:
        path.write_bytes(data[: begin + 16] + b"\xff" * 40 + data[begin + 56 :])
        reader = RrdFile(path)
        costs.add(len(everything) - len(list(reader.batches("/flight"))))
        assert (reader.damaged, reader.cut) == (1, "")
    assert costs == {0, 1}


def test_whatever_bit_of_a_message_is_flipped_the_next_one_is_read(file: Path, tmp_path: Path) -> None:
    data, path = file.read_bytes(), tmp_path / "broken.rrd"
    ends = [*messages(data)[1:], len(data)]
    for one in (data[begin:end] for begin, end in zip(messages(data), ends, strict=True)):
        path.write_bytes(data[:12] + one)
        if found(path, "/flight") and b"ticks" not in one:
            break
    whole = found(path, "/flight")
    for at in range(16, min(len(one), 1000)):
        flipped = bytearray(one)
        flipped[at] ^= 0x88
        path.write_bytes(data[:12] + flipped + one)
        assert found(path, "/flight")[-1:] == whole


def test_where_a_cut_file_ends_is_told(file: Path, tmp_path: Path) -> None:
    data = file.read_bytes()
    path = tmp_path / "cut.rrd"
    begin = messages(data)[-1]
    path.write_bytes(data[: begin + 20])
    reader = RrdFile(path)
    list(reader.batches("/flight"))
    assert reader.cut == f"it ends within a message, at byte {begin + 16} of {begin + 20}"
    path.write_bytes(data[: begin + 9])
    reader = RrdFile(path)
    list(reader.batches("/flight"))
    assert reader.cut == f"it ends within the head of a message, at byte {begin + 9}"
    path.write_bytes(data[:begin])
    reader = RrdFile(path)
    list(reader.batches("/flight"))
    assert reader.cut == ""


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "run.rrd")
    with pytest.raises(OSError, match="Invalid argument"):
        list(RrdFile(tmp_path / "run.rrd").batches("/flight"))
