from __future__ import annotations

import os
import random
import stat
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from humanoid_bt.link.ring import RingReader, RingWriter
from humanoid_bt.link.segment import LinkError
from tests.link.conftest import Start, first_line
from tests.link.workers import consistent, is_consistent

READS = int(os.environ.get("HUMANOID_BT_TORN_READS", "300000"))
"""Reads of the hostile test; millions for a long one."""

KILLS = 20
STORES_OF_A_WRITE = 5


@pytest.fixture
def ring(folder: Path) -> tuple[RingWriter, RingReader]:
    writer = RingWriter.create(folder / "ring", 64, slots=4)
    return writer, RingReader.open(folder / "ring")


def test_a_reader_gets_the_latest_payload_with_its_sequence(ring: tuple[RingWriter, RingReader]) -> None:
    writer, reader = ring
    assert reader.latest() is None
    assert reader.sequence == 0
    assert writer.write(b"one") == 1
    assert reader.latest() == (1, b"one")
    assert reader.latest() == (1, b"one")
    for _ in range(9):
        writer.write(memoryview(b"another one"))
    assert reader.latest() == (10, b"another one")
    assert reader.sequence == writer.sequence == 10


def test_payloads_from_none_to_a_whole_slot_fit_and_longer_ones_do_not(ring: tuple[RingWriter, RingReader]) -> None:
    writer, reader = ring
    for payload in (b"", b"x" * 64, bytearray(3), memoryview(bytes(64)).cast("d")):
        sequence = writer.write(payload)
        assert reader.latest() == (sequence, bytes(payload))
    for too_long in (b"x" * 65, memoryview(bytes(72)).cast("d")):
        with pytest.raises(LinkError, match=r"do not fit into a slot of 64 bytes"):
            writer.write(too_long)
    assert reader.latest() == (4, bytes(64))


def test_since_returns_every_entry_once_while_the_ring_is_long_enough(ring: tuple[RingWriter, RingReader]) -> None:
    writer, reader = ring
    assert reader.since(0) == ([], 0)
    seen = 0
    for count in (1, 3, 2):
        expected = [(writer.write(bytes([index])), bytes([index])) for index in range(count)]
        assert reader.since(seen) == (expected, 0)
        seen = expected[-1][0]
    assert reader.since(seen) == ([], 0)


def test_since_counts_what_was_overwritten(ring: tuple[RingWriter, RingReader]) -> None:
    writer, reader = ring
    for index in range(10):
        writer.write(bytes([index]))
    entries, lost = reader.since(2)
    assert [sequence for sequence, _ in entries] == [7, 8, 9, 10]
    assert lost == 4


def test_a_ring_has_one_writer_at_a_time(ring: tuple[RingWriter, RingReader], folder: Path) -> None:
    writer, reader = ring
    writer.write(b"first")
    with pytest.raises(LinkError, match="has a writer already"):
        RingWriter.open(folder / "ring")
    writer.close()
    writer.close()
    second = RingWriter.open(folder / "ring")
    assert second.write(b"second") == 2
    assert reader.latest() == (2, b"second")


def test_who_asks_for_a_writer_keeps_none_away(ring: tuple[RingWriter, RingReader], folder: Path) -> None:
    writer, reader = ring
    writer.close()
    over = threading.Event()

    def ask() -> None:
        while not over.is_set():
            _ = reader.has_writer

    asking = threading.Thread(target=ask)
    asking.start()
    try:
        for _ in range(100):
            RingWriter.open(folder / "ring").close()
    finally:
        over.set()
        asking.join()


def test_a_ring_is_private_and_made_once(ring: tuple[RingWriter, RingReader], folder: Path) -> None:
    assert stat.S_IMODE((folder / "ring").stat().st_mode) == 0o600
    with pytest.raises(LinkError, match="File exists"):
        RingWriter.create(folder / "ring", 64)
    assert [path.name for path in folder.iterdir()] == ["ring"]


def test_sizes_that_starve_readers_are_refused(folder: Path) -> None:
    for slot_size, slots in ((64, 3), (0, 8), (-1, 8)):
        with pytest.raises(ValueError, match="at least 4 slots"):
            RingWriter.create(folder / "ring", slot_size, slots)


def test_what_is_no_ring_is_refused(folder: Path) -> None:
    with pytest.raises(LinkError, match="No such file"):
        RingReader.open(folder / "ring")
    RingWriter.create(folder / "ring", 64).close()
    content = (folder / "ring").read_bytes()
    for bad in (b"", bytes(4096), content[:-64], content[:16] + b"\1" + content[17:]):
        (folder / "ring").write_bytes(bad)
        with pytest.raises(LinkError):
            RingReader.open(folder / "ring")


def test_a_damaged_slot_is_never_returned(ring: tuple[RingWriter, RingReader], folder: Path) -> None:
    writer, reader = ring
    writer.write(b"whole" * 9)
    content = bytearray((folder / "ring").read_bytes())
    position = content.index(b"whole")
    with (folder / "ring").open("r+b") as file:
        file.seek(position)
        file.write(b"t")
    assert reader.latest() is None
    assert reader.failures == 1
    assert reader.since(0) == ([], 0)
    writer.write(b"again")
    assert reader.latest() == (2, b"again")
    assert reader.since(0) == ([(2, b"again")], 1)


class KilledError(Exception):
    """The writer dies here."""


class Dying:
    """Memory in which the writer dies instead of its n-th store."""

    def __init__(self, memory: Any, left: list[int]) -> None:
        self._memory, self._left = memory, left

    def __setitem__(self, key: Any, value: Any) -> None:
        if self._left[0] == 0:
            if isinstance(key, slice):  # half of the payload gets through
                half = len(value) // 2
                self._memory[key.start : key.start + half] = value[:half]
            raise KilledError
        self._left[0] -= 1
        self._memory[key] = value


@pytest.mark.parametrize("stores", range(STORES_OF_A_WRITE))
def test_a_writer_that_dies_in_a_write_leaves_the_last_payload(folder: Path, stores: int) -> None:
    writer = RingWriter.create(folder / "ring", 64, slots=4)
    reader = RingReader.open(folder / "ring")
    for index in range(6):
        writer.write(bytes([index]) * 40)
    left = [stores]
    writer._words, writer._bytes = Dying(writer._words, left), Dying(writer._bytes, left)  # type: ignore[assignment]  # memory that dies
    with pytest.raises(KilledError):
        writer.write(b"\xff" * 64)
    assert reader.latest() == (6, b"\5" * 40)
    entries, lost = reader.since(0)
    assert [entry for entry in entries if entry[0] >= 4] == [(4, b"\3" * 40), (5, b"\4" * 40), (6, b"\5" * 40)]
    assert lost + len(entries) == 6
    writer.close()
    assert RingWriter.open(folder / "ring").write(b"next") == 7
    assert reader.latest() == (7, b"next")


@pytest.mark.parametrize(("slot_size", "slots"), [(64, 4), (1024, 8)])
def test_no_read_is_torn_beside_a_busy_writer(folder: Path, start: Start, slot_size: int, slots: int) -> None:
    RingWriter.create(folder / "ring", slot_size, slots).close()
    reader = RingReader.open(folder / "ring")
    writer = start("write_forever", folder / "ring")
    first_line(writer)
    while not reader.sequence:
        assert writer.poll() is None
    newest = torn = backwards = 0
    for _ in range(READS // 2):
        entry = reader.latest()
        if entry is None:  # damaged, or lapped again and again: counted by the reader
            continue
        sequence, payload = entry
        torn += not is_consistent(sequence, payload, slot_size)
        backwards += sequence < newest
        newest = sequence
    assert (torn, backwards) == (0, 0)
    assert reader.failures < READS // 1000


def test_no_entry_of_a_log_is_torn_or_missed_without_being_counted(folder: Path, start: Start) -> None:
    RingWriter.create(folder / "ring", 256, slots=64).close()
    reader = RingReader.open(folder / "ring")
    first_line(start("write_forever", folder / "ring"))
    seen = got = lost_in_all = 0
    for _ in range(2000):
        entries, lost = reader.since(seen)
        assert all(is_consistent(sequence, payload, 256) for sequence, payload in entries)
        got, lost_in_all = got + len(entries), lost_in_all + lost
        seen = entries[-1][0] if entries else seen
        assert got + lost_in_all == seen


def test_a_writer_killed_at_any_moment_leaves_an_intact_ring(folder: Path, start: Start) -> None:
    size, moments = 32 * 1024, random.Random(1)
    RingWriter.create(folder / "ring", size, slots=4).close()
    reader = RingReader.open(folder / "ring")
    for _ in range(KILLS):
        before = reader.sequence
        process = start("write_forever", folder / "ring")
        first_line(process)
        while reader.sequence == before:
            assert process.poll() is None
        time.sleep(moments.uniform(0.0, 0.002))
        process.kill()
        process.wait()
        entry = reader.latest()
        assert entry is not None
        assert entry[0] == reader.sequence
        assert entry[1] == consistent(entry[0], size)
        entries, _ = reader.since(0)
        assert len(entries) >= 3
        assert all(is_consistent(sequence, payload, size) for sequence, payload in entries)
    assert reader.failures == 0
