"""Damaged recordings, and files that are none: a clear answer or what is intact, from whatever looks at them."""

from __future__ import annotations

import json
import os
import random
import zlib
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.cli import main
from humanoid_bt.core.errors import UserError
from humanoid_bt.record import shape
from humanoid_bt.record.packing import BlockError, bundle, unbundle, unpack
from humanoid_bt.record.reading import FlightLog, read_flight
from humanoid_bt.review.columns import TABLES
from humanoid_bt.review.difference import difference
from humanoid_bt.review.explain import explain
from humanoid_bt.review.parameters import as_yaml
from humanoid_bt.review.recording import Recording, open_recording
from tests.record.helpers import messages
from tests.review.data.conftest import short_run

ALL, SAMPLE = 500, 20
COUNT = int(os.environ.get("HUMANOID_BT_DAMAGED", SAMPLE))


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short_run(tmp_path_factory.mktemp("recorded") / "short.rrd", duration=0.3)


def damaged(whole: bytes, count: int) -> Iterator[bytes]:
    """Yield recordings that something has happened to."""
    chance = random.Random(7)
    for number in range(count):
        data = bytearray(whole)
        at = chance.randrange(len(data))
        match number % 6:
            case 0:
                data = data[:at]
            case 1:
                for _ in range(chance.choice([1, 3, 30])):
                    data[chance.randrange(len(data))] = chance.randrange(256)
            case 2:
                data[at : at + chance.choice([8, 500, 50_000])] = chance.randbytes(chance.choice([8, 500, 50_000]))
            case 3:
                data[at:at] = chance.randbytes(chance.choice([1, 1000]))
            case 4:
                data[at : at + chance.choice([1, 1000])] = b""
            case 5:
                end = chance.randrange(len(data))
                data[at : at + 4096] = data[end : end + 4096]
        yield bytes(data)


def look_at_everything(recording: Recording, whole: Recording) -> None:
    """Ask for everything there is; what cannot be had is a clear answer."""
    for name in TABLES:
        try:
            recording.table(name, between=(0, 0.4)).validate(full=True)
        except UserError:
            continue
    as_yaml(recording)
    repr(recording)
    difference(whole, recording)


def test_a_damaged_recording_is_answered(file: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    whole, broken = open_recording(file), tmp_path / "broken.rrd"
    opened = told = 0
    for data in damaged(file.read_bytes(), COUNT):
        broken.write_bytes(data)
        try:
            recording = open_recording(broken)
        except UserError as error:
            assert "that can be read" in str(error) or "is none of a run" in str(error)
            continue
        look_at_everything(recording, whole)
        str(explain(broken))
        opened += 1
        told += bool(recording.damage)
    assert opened > COUNT // 3 and told > COUNT // 6
    assert capfd.readouterr().err == ""


@pytest.mark.trials
def test_commands_answer_too(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    broken = tmp_path / "broken.rrd"
    for number, data in enumerate(islice(damaged(file.read_bytes(), ALL), 12)):
        broken.write_bytes(data)
        export = ["export", str(broken), "--to", "csv", "-o", str(tmp_path / f"{number}"), "--between", "0", "0.1"]
        assert main(export) in (0, 2)
        assert main(["params", str(broken)]) in (0, 2)
        assert main(["diff", str(file), str(broken)]) in (0, 1, 2)
    assert "Traceback" not in capsys.readouterr().err


@pytest.mark.parametrize("content", [b"", b"RRF2", b"hello\n" * 1000, b"PK\x03\x04" + bytes(5000), bytes(4096), None])
def test_what_is_no_recording_is_answered(content: bytes | None, tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    if content is None:
        path.mkdir()
    else:
        path.write_bytes(content)
    with pytest.raises(UserError, match=r"is no recording that can be read|is none of a run"):
        open_recording(path)


# ---- what a block holds ---------------------------------------------------------------------------------------------

ODD: list[Any] = [None, True, -1, 1e308, "text", "\ud800", [], [None], {}, {"a": 1}, [[[]]], {"path": 3, "value": {}}]


def log_with(setup: dict[str, Any], news: list[Any], layout: dict[str, Any]) -> FlightLog:
    log = FlightLog(Path("made.rrd"), setup=shape.SETUP(setup), layout=shape.LAYOUT(layout))
    log.blocks["news"] = [bundle([json.dumps(entry).encode() for entry in news])]
    log.until["news"] = [1.0]
    return log


def test_entries_of_other_shapes_are_left_out_and_counted(file: Path) -> None:
    chance, whole = random.Random(3), open_recording(file)
    for _ in range(200):
        setup = {key: mangled(value, chance) for key, value in whole.setup.items()}
        recording = Recording(log_with(setup, odd_news(chance), {}))
        look_at_everything(recording, whole)


def mangled(data: Any, chance: random.Random) -> Any:
    """Return data in which something here and there is something else."""
    if chance.random() < 0.03:
        return chance.choice(ODD)
    if isinstance(data, dict):
        return {key: mangled(value, chance) for key, value in data.items()}
    if isinstance(data, list):
        return [mangled(value, chance) for value in data]
    return data


def test_a_recording_that_says_something_else_is_explained(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    chance, whole = random.Random(4), read_flight(file)
    log = FlightLog(file)
    monkeypatch.setattr("humanoid_bt.review.explain.read_flight", lambda _: log)
    explained = 0
    for number in range(COUNT // 2):
        log = read_flight(file)
        if number % 2:
            log.setup = shape.SETUP(mangled(whole.setup, chance))
            log.layout = shape.LAYOUT(mangled(whole.layout, chance)) if number % 4 == 1 else whole.layout
        else:
            log.blocks["news"] += log_with({}, odd_news(chance), {}).blocks["news"]
            log.until["news"] += [1.0]
        asked: list[dict[str, Any]] = [{}, {"at": 0.1}, {"node": "approach"}, {"joint": "left_knee"}]
        for question in asked:
            try:
                explained += bool(str(explain(file, **question)))
            except UserError as error:
                assert "has no servo cycles" in str(error) or "named 'approach'" in str(error) or "joint" in str(error)
    assert explained > COUNT


def odd_news(chance: random.Random) -> list[Any]:
    """Return what nobody can have told."""
    kinds = ["node", "results", "event", "key", "unseen", "input", "stop", "tree", "end", "limits"]
    times = [0.05, 0.5, -1.0, 1e300, float("nan"), float("inf"), "soon"]
    return [[chance.choice(times), chance.choice(kinds), chance.choice(ODD)] for _ in range(5)]


@pytest.mark.filterwarnings("ignore:overflow")
def test_a_layout_that_is_none_is_answered(file: Path) -> None:
    chance, log = random.Random(5), read_flight(file)
    whole = log.layout
    for _ in range(100):
        log.layout = shape.LAYOUT(mangled(whole, chance))
        for name in ("joints", "body"):
            try:
                Recording(log).table(name, between=(0, 0.1)).validate(full=True)
            except UserError as error:
                assert "servo cycles" in str(error)


def test_damaged_blocks_are_counted(file: Path) -> None:
    log = read_flight(file)
    for name in ("cycles", "ticks"):
        log.blocks[name][2] = log.blocks[name][2][:-9] + b"something"
    recording = Recording(log)
    count = len(log.blocks["cycles"]), len(log.blocks["ticks"])
    assert recording.damage == [
        f"1 of {count[0]} blocks of cycles are damaged",
        f"1 of {count[1]} blocks of ticks are damaged",
    ]
    assert 0 < recording.joints().num_rows < open_recording(file).joints().num_rows


def test_an_explanation_tells_what_is_damaged(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    log = read_flight(file)
    monkeypatch.setattr("humanoid_bt.review.explain.read_flight", lambda _: log)
    assert "damaged" not in dict(explain(file).rows)
    log.blocks["ticks"][2] = log.blocks["ticks"][2][:-9] + b"something"
    count = len(log.blocks["ticks"])
    assert dict(explain(file).rows)["damaged"] == f"1 of {count} blocks of ticks are damaged"
    log = read_flight(file)
    log.blocks["news"] = [b"nonsense" for _ in log.blocks["news"]]
    found = explain(file)
    assert found.kind == "damaged"
    assert found.headline.endswith("s, and does not say how the run ended: it is damaged")


def test_zeros_are_no_end_of_a_recording(file: Path, tmp_path: Path) -> None:
    data, path = file.read_bytes(), tmp_path / "zeros.rrd"
    begin = messages(data)[-80]
    path.write_bytes(data[:begin] + bytes(4096) + data[begin + 4096 :])
    whole, found = open_recording(file), open_recording(path)
    assert found.damage
    assert found.ended == whole.ended and found.outcome == whole.outcome


def test_the_first_and_the_last_blocks_are_not_missed(file: Path) -> None:
    log = read_flight(file)
    whole, blocks = Recording(log).joints(rate=1000)["time"].to_pylist(), log.blocks["cycles"]
    assert len(blocks) > 4
    for number in (0, 1, -1):
        blocks[number] = b"nonsense"
    times = Recording(log).joints(rate=1000)["time"].to_pylist()
    assert whole[0] < times[0] < log.until["cycles"][2]
    assert log.until["cycles"][-3] <= times[-1] < whole[-1]


def test_few_bytes_cannot_become_many() -> None:
    packed = zlib.compress(bytes(20_000_000), 9)
    for small in (1, 1000):
        with pytest.raises(BlockError):
            unbundle(reading_header(small, packed))
    columns = 10
    with pytest.raises(BlockError):
        unpack(block_header(columns, packed), [1.0] * columns)  # type: ignore[arg-type]  # what bytes may claim
    with pytest.raises(BlockError):
        unbundle(reading_header(3, zlib.compress(b"abc")))


def reading_header(size: int, packed: bytes) -> bytes:
    """Return a bundle that claims to be so many bytes."""
    return (1).to_bytes(4, "little") + size.to_bytes(4, "little") + zlib.crc32(packed).to_bytes(8, "little") + packed


def block_header(columns: int, packed: bytes) -> bytes:
    """Return a block that claims to have two rows."""
    numbers = b"\x01" + (2).to_bytes(4, "little") + columns.to_bytes(4, "little")
    return numbers + zlib.crc32(packed).to_bytes(8, "little") + packed
