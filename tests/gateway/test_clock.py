"""ROS time beside engine time."""

from __future__ import annotations

import pytest

from humanoid_bt.gateway.clock import EngineClock


class Clocks:
    def __init__(self) -> None:
        self.ros, self.mono = 1e9, 100.0

    def passes(self, duration: float) -> None:
        self.ros, self.mono = self.ros + duration, self.mono + duration


@pytest.fixture
def clocks() -> Clocks:
    return Clocks()


@pytest.fixture
def clock(clocks: Clocks) -> EngineClock:
    return EngineClock(lambda: clocks.ros, lambda: clocks.mono)


def test_stamps_go_there_and_back(clocks: Clocks, clock: EngineClock) -> None:
    clock.look(3.0)
    assert clock.engine(1e9) == pytest.approx(3.0, abs=1e-6)
    assert clock.ros(2.5) == pytest.approx(1e9 - 0.5, abs=1e-6)


def test_a_state_that_was_read_late_does_not_move_the_clock(clocks: Clocks, clock: EngineClock) -> None:
    clock.look(3.0)
    clocks.passes(0.02)
    clock.look(3.016)  # 4 ms old
    assert clock.now() == pytest.approx(3.02, abs=1e-6)


def test_engine_time_may_fall_behind(clocks: Clocks, clock: EngineClock) -> None:
    clock.look(0.0)
    for look in range(1, 101):
        clocks.passes(0.02)
        clock.look(0.01 * look)
    assert clock.now() == pytest.approx(1.0, abs=0.6)
    for look in range(1, 101):
        clocks.passes(0.02)
        clock.look(1.0 + 0.02 * look)
    assert clock.now() == pytest.approx(3.0, abs=1e-6)


def test_while_control_stands_still_its_time_goes_on_here(clocks: Clocks, clock: EngineClock) -> None:
    clock.look(3.0)
    clocks.passes(0.5)
    assert clock.look(3.0) == 0.0
    assert clock.now() == pytest.approx(3.5, abs=1e-6)


@pytest.mark.parametrize("jump", [-40.0, 0.2, 3600.0])
def test_a_jump_of_ros_time_is_told_and_followed(clocks: Clocks, clock: EngineClock, jump: float) -> None:
    clock.look(3.0)
    clocks.passes(0.02)
    clocks.ros += jump
    assert clock.look(3.02) == pytest.approx(jump, abs=1e-6)
    assert clock.engine(clocks.ros) == pytest.approx(3.02, abs=1e-6)
    clocks.passes(0.02)
    assert clock.look(3.04) == 0.0
