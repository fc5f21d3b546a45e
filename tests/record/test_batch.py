"""What cannot be drawn costs no more than itself, and is told."""

from __future__ import annotations

import logging
import math
import socket
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr

from humanoid_bt.record.batch import Batch
from humanoid_bt.record.reading import read_flight
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.record.recorder_process import RecorderProcess
from tests.record.helpers import make_state, make_track, rows

Maker = Callable[..., Recorder]


@pytest.fixture(autouse=True)
def strict() -> Iterator[None]:
    """As in the recorder's process: else the library warns, and leaves out a whole batch."""
    rr.set_strict_mode(True)
    yield
    rr.set_strict_mode(False)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


@pytest.fixture
def ends() -> Iterator[tuple[socket.socket, socket.socket]]:
    one, other = socket.socketpair()
    with one, other:
        yield one, other


def test_items_that_fail_are_left_out_and_told_once(caplog: pytest.LogCaptureFixture) -> None:
    drawn: list[float] = []

    def draw(items: Sequence[float]) -> None:
        drawn.extend([1 / item for item in items])

    batch: Batch[float] = Batch("numbers")
    for _ in range(2):
        for item in (1.0, 0.0, 2.0, 0.0):
            batch.append(item)
        batch.draw(draw, lambda items: None)
    batch.draw(draw)
    assert drawn == 2 * [1.0, 0.5]
    assert [record.getMessage().partition(":")[0] for record in caplog.records] == [
        "something of numbers cannot be drawn, and is left out"
    ]


def test_a_way_that_cannot_be_drawn_costs_itself(record: Maker, file: Path, caplog: pytest.LogCaptureFixture) -> None:
    ways = {0.04: [[0.0, 0.0], [1.0, 0.0]], 0.08: [[0.0, 0.0, 0.0]], 0.12: [[0.0, 0.0], [0.0, 1.0]]}
    with record() as recorder:
        recorder.sample(make_state(0.0), {}, {})
        for time, way in ways.items():
            recorder.routes(time, [way])
            with suppress(ValueError):  # told by the process
                recorder.sample(make_state(time), {}, {})
    assert [time for time, _ in rows(file, "/world/route", "LineStrips3D:strips")] == [0.04, 0.12]
    assert [time for time, _ in rows(file, "/world/gaze", "LineStrips3D:strips")] == [0.0, *ways]
    assert "the way round obstacles" in caplog.text


def test_what_is_wrong_in_one_view_costs_no_other(record: Maker, file: Path) -> None:
    odd = make_track("\udc80", position=(1, 2, 3), confidence=1.0, age=0.1)
    with record() as recorder:
        recorder.sample(make_state(0.0), {odd.name: odd}, {})
        recorder.sample(make_state(0.04), {}, {})
    for entity, component in (("/world/gaze", "LineStrips3D:strips"), ("/robot/tilt", "Scalars:scalars")):
        assert [time for time, _ in rows(file, entity, component)] == [0.0, 0.04]


def test_the_eye_finds_the_robot_again(record: Maker, file: Path) -> None:
    lost = replace(make_state(0.04), stance=np.full(3, math.nan))
    with record() as recorder:
        for state in (make_state(0.0), lost, make_state(0.08)):
            recorder.sample(state, {}, {})
    finite = [bool(np.isfinite(place).all()) for _, place in rows(file, "/eye", "Transform3D:translation")]
    assert finite == [True, False, True]


def test_a_call_that_fails_ends_no_recording(
    ends: tuple[socket.socket, socket.socket], record: Maker, file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(logging.getLogger(), "handlers", [])
    with record() as recorder:
        process = RecorderProcess(ends[1])
        process._recorder = recorder
        for number in range(2):
            assert process._obey(recorder, "news", (0.1 * number, "event", object()))
        assert process._obey(recorder, "sample", (make_state(1.0), {}, {"nowhere": np.zeros(3)}))
        assert process._obey(recorder, "news", (1.0, "event", ["info", "the last"]))
    told = [line.partition(", and is left out")[0] for line in ends[0].recv(1 << 16).decode().splitlines()]
    assert sum("something (news) cannot be recorded" in line for line in told) == 1
    assert sum("something (sample) cannot be recorded" in line for line in told) == 1
    assert [news.value for news in read_flight(file).news] == [["info", "the last"]]
    assert rows(file, "/robot/tilt", "Scalars:scalars")
