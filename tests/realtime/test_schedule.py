"""The schedule, on a clock that stands still unless it is told to go."""

from __future__ import annotations

from humanoid_bt.realtime.schedule import SPIN, Schedule

US, MS = 1_000, 1_000_000  # ns


class Clock:
    """A clock that sleeping moves on; reading it takes a microsecond."""

    def __init__(self, oversleep: int = 0) -> None:
        self.time, self.oversleep = 0, oversleep
        self.sleeps: list[int] = []

    def now(self) -> int:
        self.time += US
        return self.time

    def sleep_until(self, due: int) -> None:
        self.sleeps.append(due)
        self.time = max(self.time, due) + self.oversleep


def schedule(clock: Clock, spin: bool = False) -> Schedule:
    made = Schedule(0.001, spin, clock.now, clock.sleep_until)
    clock.time = 0
    return made


def test_wakes_up_at_whole_periods_without_drift() -> None:
    clock = Clock(oversleep=70 * US)
    times = schedule(clock)
    for _ in range(1000):
        late, skipped = times.wait()
        assert (late, skipped) == (71 * US, 0)
        clock.time += 300 * US  # the work
    assert clock.sleeps[:2] == [MS + US, 2 * MS + US]
    assert clock.sleeps[-1] == 1000 * MS + US
    assert times.missed == 0


def test_spinning_takes_what_a_sleep_oversleeps() -> None:
    clock = Clock(oversleep=70 * US)
    times = schedule(clock, spin=True)
    late, _ = times.wait()
    assert 0 <= late <= US
    assert clock.sleeps == [MS + US - SPIN]


def test_missed_wake_ups_are_skipped_and_counted_never_caught_up() -> None:
    clock = Clock()
    times = schedule(clock)
    times.wait()
    clock.time += 5 * MS + 500 * US
    late, skipped = times.wait()
    assert skipped == 4
    assert 500 * US <= late < MS
    late, skipped = times.wait()
    assert (late, skipped) == (US, 0)
    assert clock.time // MS == 7, "one wake-up per period, no burst"
    assert times.missed == 4


def test_a_wake_up_that_is_late_by_less_than_a_period_is_not_skipped() -> None:
    clock = Clock()
    times = schedule(clock)
    times.wait()
    clock.time += MS + 400 * US
    late, skipped = times.wait()
    assert skipped == 0
    assert 400 * US <= late < 410 * US
    assert times.missed == 0


def test_a_sleep_that_a_signal_cut_short_is_made_up_for() -> None:
    clock = Clock()
    times = Schedule(0.001, False, clock.now, lambda _due: None)
    clock.time = 0
    late, skipped = times.wait()
    assert clock.time >= MS
    assert late <= US
    assert skipped == 0


def test_wake_ups_that_were_slept_through_are_told_at_once() -> None:
    clock = Clock(oversleep=5 * MS)
    times = schedule(clock)
    late, skipped = times.wait()
    assert skipped == 5 == times.missed
    assert 5 * MS <= late < 6 * MS
    clock.oversleep = 0
    assert times.wait() == (US, 0)
    assert clock.sleeps[-1] == 7 * MS + US
