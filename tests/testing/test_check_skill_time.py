"""Real time while a skill is tried: whose clock is read, and the alarm that ends a tick, leave no trace."""

from __future__ import annotations

import signal
import sys
import time
from collections.abc import Iterator
from datetime import date, datetime
from pathlib import Path

import pytest

from humanoid_bt.testing.check_skill_time import TooLong, at_most, clocks_read

HERE = Path(__file__).parent


def test_every_wall_clock_is_noticed_where_it_is_read_first() -> None:
    with clocks_read(HERE) as found:
        time.time_ns()
        time.time_ns()
        time.perf_counter()
        datetime.now()
        date.today()
        [].append(time.sleep(0))
    assert {name: place.line - found["time.time_ns"].line for name, place in found.items()} == {
        "time.time_ns": 0,
        "time.perf_counter": 2,
        "datetime.now": 3,
        "date.today": 4,
    }


def test_clocks_that_others_read_are_their_affair(tmp_path: Path) -> None:
    with clocks_read(tmp_path) as found:
        time.time()
    assert not found


def test_who_looked_on_before_does_so_again(tmp_path: Path) -> None:
    def profile(*_event: object) -> None:
        """Look on."""

    before = sys.getprofile()
    try:
        sys.setprofile(profile)
        with clocks_read(tmp_path):
            pass
        assert sys.getprofile() is profile
    finally:
        sys.setprofile(before)


@pytest.fixture
def alarm() -> Iterator[None]:
    """Set an alarm of somebody else's, in a minute."""
    handler = signal.signal(signal.SIGALRM, _ring)
    signal.setitimer(signal.ITIMER_REAL, 60)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, handler)


def _ring(*_signal: object) -> None:
    pytest.fail("the alarm of somebody else")


@pytest.mark.parametrize("seconds", [0.001, 30.0])
def test_an_alarm_that_was_set_before_is_set_again(alarm: None, seconds: float) -> None:
    try:
        with at_most(seconds):
            while seconds < 1:
                pass
    except TooLong as error:
        assert str(error) == "after 0.001 s"
    assert 30 < signal.getitimer(signal.ITIMER_REAL)[0] <= 60
    assert signal.getsignal(signal.SIGALRM) is _ring
