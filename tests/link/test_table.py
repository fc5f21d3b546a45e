"""Tables of numbers: what was published is read once, in order, and what is lost is counted."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from humanoid_bt.link.ring import RingWriter
from humanoid_bt.link.segment import LinkError
from humanoid_bt.link.table import TableReader, TableWriter

WIDTH, ROWS = 3, 10


@pytest.fixture
def path(folder: Path) -> Path:
    return folder / "table"


def write(writer: TableWriter, count: int) -> None:
    for _ in range(count):
        writer.rows[writer.count % ROWS] = writer.count
        writer.publish()


def test_rows_are_read_once_and_in_order(path: Path) -> None:
    writer = TableWriter.create(path, WIDTH, ROWS)
    reader = TableReader.open(path)
    assert reader.since(0)[0].shape == (0, WIDTH)
    write(writer, 5)
    rows, lost = reader.since(0)
    assert (rows[:, 0].tolist(), lost) == ([0, 1, 2, 3, 4], 0)
    write(writer, 2)
    rows, lost = reader.since(5)
    assert (rows[:, 2].tolist(), lost) == ([5, 6], 0)


def test_what_a_late_reader_lost_is_counted(path: Path) -> None:
    writer = TableWriter.create(path, WIDTH, ROWS)
    reader = TableReader.open(path)
    write(writer, 25)
    rows, lost = reader.since(3)
    assert rows[:, 0].tolist() == [17, 18, 19, 20, 21, 22, 23, 24]
    assert lost == 14


def test_rows_that_are_overwritten_while_they_are_copied_are_left_out(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    writer = TableWriter.create(path, WIDTH, ROWS)
    reader = TableReader.open(path)
    write(writer, 8)
    arange = np.arange

    def meanwhile(first: int, end: int) -> np.ndarray:
        write(writer, 4)
        return arange(first, end)

    monkeypatch.setattr(np, "arange", meanwhile)
    rows, lost = reader.since(0)
    assert (rows[:, 0].tolist(), lost) == ([4, 5, 6, 7], 4)


def test_a_copy_stays_as_it_was(path: Path) -> None:
    writer = TableWriter.create(path, WIDTH, ROWS)
    write(writer, 1)
    rows, _ = TableReader.open(path).since(0)
    write(writer, ROWS)
    assert rows.tolist() == [[0, 0, 0]]


def test_there_is_one_writer_and_the_next_goes_on(path: Path) -> None:
    first = TableWriter.create(path, WIDTH, ROWS)
    write(first, 2)
    with pytest.raises(LinkError, match="has a writer already"):
        TableWriter.open(path)
    first.close()
    second = TableWriter.open(path)
    write(second, 1)
    assert TableReader.open(path).since(0)[0][:, 0].tolist() == [0, 1, 2]


def test_what_is_no_table_is_refused(path: Path) -> None:
    RingWriter.create(path, 64).close()
    with pytest.raises(LinkError, match="does not hold a table"):
        TableReader.open(path)


def test_a_table_cut_short_is_refused(path: Path) -> None:
    TableWriter.create(path, WIDTH, ROWS).close()
    with path.open("r+b") as file:
        file.truncate(200)
    with pytest.raises(LinkError, match="damaged table"):
        TableReader.open(path)


def test_sizes_that_cannot_work_are_refused(path: Path) -> None:
    with pytest.raises(ValueError, match="at least 8 rows"):
        TableWriter.create(path, WIDTH, 4)
