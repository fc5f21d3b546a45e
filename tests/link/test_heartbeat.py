from __future__ import annotations

from pathlib import Path

import pytest

from humanoid_bt.link.estop import EStop
from humanoid_bt.link.heartbeat import Heartbeat
from humanoid_bt.link.segment import LinkError
from tests.link.conftest import Start, first_line


def test_each_beat_counts_one_for_everybody(folder: Path) -> None:
    ours, theirs = Heartbeat.create(folder / "decision"), Heartbeat.open(folder / "decision")
    assert theirs.count == 0
    ours.beat()
    ours.beat()
    assert theirs.count == ours.count == 2


def test_a_loop_that_starts_again_goes_on_counting(folder: Path) -> None:
    first = Heartbeat.create(folder / "decision")
    first.beat()
    first.close()
    again = Heartbeat.open(folder / "decision")
    again.beat()
    assert again.count == 2


def test_the_counter_of_a_killed_process_stands_still(folder: Path, start: Start) -> None:
    heartbeat = Heartbeat.create(folder / "decision")
    process = start("beat_forever", folder / "decision")
    first_line(process)
    while heartbeat.count < 1000:
        assert process.poll() is None
    process.kill()
    process.wait()
    count = heartbeat.count
    assert all(heartbeat.count == count for _ in range(1000))


def test_a_heartbeat_is_not_taken_for_something_else(folder: Path) -> None:
    Heartbeat.create(folder / "decision")
    with pytest.raises(LinkError, match=r"is too short: \d+ bytes"):
        EStop.open(folder / "decision")
    with pytest.raises(LinkError, match="No such file"):
        Heartbeat.open(folder / "perception")
