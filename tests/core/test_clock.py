from __future__ import annotations

import pytest

from humanoid_bt.core.clock import (
    DECISION_PERIOD,
    ESTIMATE_PERIOD,
    PERCEPTION_PERIOD,
    SERVO_PERIOD,
    WHOLE_BODY_PERIOD,
    CycleClock,
    cycles,
)


def test_durations_count_in_servo_cycles() -> None:
    assert cycles(0) == 0
    assert cycles(SERVO_PERIOD) == 1
    assert cycles(0.1) == 100
    assert cycles(3600.005) == 3_600_005


@pytest.mark.parametrize(("seconds", "count"), [(0.0004, 0), (0.0026, 3), (0.0204, 20), (1 / 3, 333)])
def test_a_duration_between_cycles_takes_the_nearest(seconds: float, count: int) -> None:
    assert cycles(seconds) == count


def test_every_loop_is_a_whole_number_of_the_faster_ones() -> None:
    for period in (ESTIMATE_PERIOD, WHOLE_BODY_PERIOD, DECISION_PERIOD, PERCEPTION_PERIOD):
        assert cycles(period) * SERVO_PERIOD == pytest.approx(period)
    assert cycles(ESTIMATE_PERIOD) == 5
    assert cycles(WHOLE_BODY_PERIOD) == 10
    assert cycles(WHOLE_BODY_PERIOD) % cycles(ESTIMATE_PERIOD) == 0
    assert cycles(DECISION_PERIOD) % cycles(WHOLE_BODY_PERIOD) == 0
    assert cycles(PERCEPTION_PERIOD) % cycles(DECISION_PERIOD) == 0


def test_the_clock_counts_cycles_without_drift() -> None:
    clock = CycleClock()
    assert clock.now() == 0
    for _ in range(100_000):
        clock.cycle += 1
    assert clock.now() == pytest.approx(100, abs=1e-12)


def test_a_loop_is_due_at_the_start_and_then_every_period() -> None:
    clock, ran = CycleClock(), []
    for _ in range(41):
        if clock.due(20):
            ran.append(clock.cycle)
        clock.cycle += 1
    assert ran == [0, 20, 40]
