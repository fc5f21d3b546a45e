"""The arithmetic of lateness."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.bench.punctuality import percentile, punctuality
from humanoid_bt.realtime.timing import STOP_ROOM, Histogram, StopRecord, Wake

MS = 1_000_000  # ns


@pytest.mark.parametrize(("share", "value"), [(0.5, 50), (0.99, 99), (0.999, 100), (1.0, 100)])
def test_percentile_is_the_nearest_rank(share: float, value: float) -> None:
    assert percentile(range(100, 0, -1), share) == value


def test_percentile_of_few_is_the_largest_and_of_none_is_zero() -> None:
    assert percentile([3.0, 1.0], 0.99) == 3.0
    assert percentile([], 0.5) == 0.0


@pytest.mark.parametrize("share", [0.5, 0.99, 0.999])
def test_histogram_agrees_with_the_exact_percentile_within_a_bin(share: float) -> None:
    durations = np.random.default_rng(0).exponential(50_000, 20_000).astype(int)
    histogram = Histogram()
    for duration in durations.tolist():
        histogram.add(duration)
    assert histogram.percentile(share) == pytest.approx(percentile(durations / 1e3, share), abs=1.0)
    assert histogram.count == len(durations)


def test_histogram_never_claims_more_than_the_largest() -> None:
    histogram = Histogram()
    assert histogram.percentile(0.99) == 0.0
    histogram.add(200)
    assert histogram.percentile(0.99) == pytest.approx(0.2)
    histogram.add(65 * MS)  # beyond the last bin
    assert histogram.percentile(1.0) == pytest.approx(65_000)


def test_punctuality_of_a_loop_that_missed_a_wake_up() -> None:
    woke = [0, MS, 2 * MS + 40_000, 4 * MS]
    figure = punctuality("x", loaded=False, fifo=True, woke=woke, late=[0, 0, 40_000, 0], skipped=[0, 0, 0, 1])
    assert (figure.cycles, figure.missed) == (4, 1)
    assert (figure.late_p50, figure.late_max) == (0.0, 40.0)
    assert figure.jitter_p50 == pytest.approx(40.0)
    assert figure.jitter_p99 == pytest.approx(960.0)


def test_records_survive_the_wire() -> None:
    assert Wake.from_bytes(Wake.pack(5, 4, 3, 2)) == Wake(woke=5, late=4, busy=3, skipped=2)
    stop = StopRecord(123, 1.5, "emergency_stop", "ünwell\n", "a person")
    assert StopRecord.from_bytes(stop.to_bytes()) == stop


def test_a_stop_with_endless_texts_fits_its_slot() -> None:
    assert len(StopRecord(1, 1.0, "damp", "\x00" * 5000, "\x00" * 5000).to_bytes()) <= STOP_ROOM
