"""Simulated time, held back to a pace."""

from __future__ import annotations

import pytest

from humanoid_bt.session import pace
from humanoid_bt.session.pace import Pace


class Wall:
    """A wall clock that only goes on when somebody sleeps or works."""

    def __init__(self) -> None:
        self.now = 100.0
        self.slept: list[float] = []

    def monotonic(self) -> float:
        return self.now

    def sleep(self, duration: float) -> None:
        self.slept.append(round(duration, 6))
        self.now += duration


@pytest.fixture
def wall(monkeypatch: pytest.MonkeyPatch) -> Wall:
    wall = Wall()
    monkeypatch.setattr(pace, "time", wall)
    return wall


def test_it_sleeps_until_a_time_is_due(wall: Wall) -> None:
    twice = Pace(2.0)
    for now in (0.02, 0.04, 0.06):
        twice.keep(now)
        wall.now += 0.004
    assert wall.slept == [0.006, 0.006]


def test_without_a_pace_it_never_sleeps(wall: Wall) -> None:
    free = Pace(None)
    free.keep(0.02)
    free.keep(1000.0)
    assert wall.slept == []


@pytest.mark.parametrize(("pause", "slept"), [(0.2, []), (60.0, [0.1])])
def test_a_short_delay_is_caught_up_and_a_long_pause_is_not(wall: Wall, pause: float, slept: list[float]) -> None:
    real = Pace(1.0)
    real.keep(0.0)
    wall.now += pause + 1.0
    real.keep(1.0)
    real.keep(1.1)
    assert wall.slept == slept
