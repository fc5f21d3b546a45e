"""Servo cycles in a recording: all of them, as they were, from both ways they come in."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
import rerun as rr

from humanoid_bt.control.cycle_log import Layout
from humanoid_bt.core.errors import UserError
from humanoid_bt.link.table import TableReader, TableWriter
from humanoid_bt.record.columns import send
from humanoid_bt.record.flight import FLIGHT, Flight, _Follower
from humanoid_bt.record.reading import read_cycles, read_flight
from humanoid_bt.record.recorder import Recorder
from humanoid_bt.session.session import Session
from tests.record.conftest import JOINTS
from tests.record.helpers import make_state

Maker = Callable[..., Recorder]
LAYOUT = Layout.of(JOINTS)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "run.rrd"


def some(first: int, count: int, width: int) -> np.ndarray:
    """Return rows whose first number counts."""
    numbers = np.arange(first, first + count, dtype=float)
    return np.column_stack([numbers, np.sin(numbers[:, None] * 1e-3 + np.arange(width - 1))])


def test_a_run_has_every_cycle_as_it_was(tmp_path: Path, file: Path) -> None:
    with Session("stand", duration=0.3, record=file) as session:
        session.run()
        state = session.engine.sense()[0]
    cycles, plans = read_cycles(file), read_cycles(file, "plans")
    assert (np.diff(cycles.time) == pytest.approx(1e-3)) and cycles.time[0] == pytest.approx(1e-3)
    assert cycles.time[-1] == pytest.approx(state.time)
    np.testing.assert_allclose(cycles.columns["position"][-1], state.joint_positions, atol=1e-5)
    np.testing.assert_allclose(cycles.columns["base_position"][-1], state.base_position, atol=6e-6)
    np.testing.assert_allclose(plans.columns["setpoint"][-1], state.setpoint_positions, atol=1e-5)
    assert cycles.described["position"].unit == "rad"
    assert cycles.described["position"].labels == session.engine.robot.joint_names


def test_batches_follow_each_other(record: Maker, file: Path) -> None:
    with record() as recorder:
        for tick in range(120):
            recorder.sample(make_state(0.02 * tick), {}, {})
            recorder.cycles(some(4 * tick, 4, LAYOUT.plan.width), some(20 * tick, 20, LAYOUT.cycle.width))
    assert read_cycles(file).columns["servo"][:, 0].tolist() == list(range(2400))
    assert read_cycles(file, "plans").columns["plan"][:, 0].tolist() == list(range(480))


def test_tables_are_read_until_nobody_writes_them(record: Maker, file: Path, tmp_path: Path) -> None:
    paths = tmp_path / "plans", tmp_path / "cycles"
    LAYOUT.create(*paths)
    writers = [TableWriter.open(path) for path in paths]
    with record() as recorder:
        recorder.follow(*paths)
        for writer, row in zip(writers, (LAYOUT.plan, LAYOUT.cycle), strict=True):
            for number in range(300):
                writer.rows[number % len(writer.rows)] = some(number, 1, row.width)
                writer.publish()
            writer.close()
    assert read_cycles(file).columns["servo"][:, 0].tolist() == list(range(300))
    assert read_cycles(file, "plans").columns["plan"][:, 0].tolist() == list(range(300))


def test_what_was_taken_too_late_is_told(record: Maker, file: Path, tmp_path: Path) -> None:
    paths = tmp_path / "plans", tmp_path / "cycles"
    LAYOUT.create(*paths)
    writers = [TableWriter.open(path) for path in paths]
    for writer, row in zip(writers, (LAYOUT.plan, LAYOUT.cycle), strict=True):
        for number in range(5000):
            writer.rows[number % len(writer.rows)] = some(number, 1, row.width)
            writer.publish()
        writer.close()
    with record() as recorder:
        recorder.follow(*paths)
    assert recorder.trouble == "servo cycles are missing in the recording before 1.00 s: they were taken too late"
    assert read_cycles(file).columns["servo"][0, 0] == 1002


def test_what_was_taken_too_late_once_more_is_told_once_more(tmp_path: Path) -> None:
    paths = tmp_path / "plans", tmp_path / "cycles"
    LAYOUT.create(*paths)
    plans, cycles = (TableReader.open(path) for path in paths)
    follower, writer = _Follower(Flight(JOINTS, {}), plans, cycles), TableWriter.open(paths[1])
    found = []
    for count in (5000, 20, 5000, 20_000):
        for _ in range(count):
            writer.publish()
        follower._take()
        found.append(follower.trouble)
    told = "servo cycles are missing in the recording before {} s: they were taken too late".format
    assert found == [told("1.00"), told("1.00"), told("1.00"), told("26.02")]


def test_a_file_without_them_is_answered(tmp_path: Path) -> None:
    other = tmp_path / "other.rrd"
    with rr.RecordingStream("other") as stream:
        stream.save(other)
        stream.log("text", rr.TextLog("hello"))
    with pytest.raises(UserError, match="is none of a run") as error:
        read_cycles(other)
    assert "cut short" in str(error.value)
    damaged = tmp_path / "damaged.rrd"
    damaged.write_bytes(b"no recording")
    for path in (damaged, tmp_path / "missing.rrd"):
        with pytest.raises(UserError, match="no recording that can be read"):
            read_cycles(path)


@pytest.mark.parametrize("entries", [pa.array(["text"]), pa.array([[]], pa.list_(pa.binary()))])
def test_entries_that_are_none_are_counted(record: Maker, file: Path, entries: pa.Array) -> None:
    with record(setup={"seed": 0}) as recorder:
        recorder.sample(make_state(0.0), {}, {})
        send(recorder._outlet.stream, FLIGHT, [1.0], rr.AnyValues.columns(ticks=entries))
    assert read_flight(file).damage == ["1 entries cannot be read"]


def recorded(folder: Path, duration: float) -> Path:
    """Let the robot stand for a while [s], and return the recording of it."""
    file = folder / "run.rrd"
    with Session("stand", duration=duration, record=file, camera=False) as session:
        session.run()
    return file


@pytest.fixture(scope="module")
def stood(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a short run."""
    return recorded(tmp_path_factory.mktemp("stood"), 1.0)


@pytest.fixture(scope="module")
def longer(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The recording of a run long enough for the last fifth of the file to begin among its servo cycles."""
    return recorded(tmp_path_factory.mktemp("longer"), 4.0)


@pytest.mark.trials
def test_a_part_of_the_cycles_is_as_in_all_of_them(stood: Path) -> None:
    log = read_flight(stood)
    for kind in ("cycles", "plans"):
        whole, part = log.cycles(kind), log.cycles(kind, 0.3, 0.7)
        inside = (whole.time > 0.2999) & (whole.time < 0.7001)
        np.testing.assert_array_equal(part.time, whole.time[inside])
        for name, values in part.columns.items():
            np.testing.assert_array_equal(values, whole.columns[name][inside])
    torque = log.cycles("cycles", 0.3, 0.7, ["torque"])
    assert list(torque.columns) == ["torque"]
    np.testing.assert_array_equal(torque.columns["torque"], log.cycles("cycles", 0.3, 0.7).columns["torque"])


def test_a_part_of_the_ticks_is_as_in_all_of_them(stood: Path) -> None:
    log = read_flight(stood)
    times = [tick.state.time for tick in log.ticks() if 0.2999 < tick.state.time < 0.7001]
    assert [tick.state.time for tick in log.ticks(0.3, 0.7)] == times
    assert log.span == pytest.approx((0.001, 1.0), abs=0.03)


@pytest.mark.parametrize("share", [0.8, 0.9, 0.999])
def test_a_file_that_was_cut_is_read_as_far_as_it_goes(longer: Path, tmp_path: Path, share: float) -> None:
    cut = tmp_path / "cut.rrd"
    cut.write_bytes(longer.read_bytes()[: int(share * longer.stat().st_size)])
    whole, part = read_flight(longer), read_flight(cut)
    assert part.setup == whole.setup
    assert 0 < len(part.blocks["cycles"]) <= len(whole.blocks["cycles"])
    assert part.blocks["cycles"] == whole.blocks["cycles"][: len(part.blocks["cycles"])]
