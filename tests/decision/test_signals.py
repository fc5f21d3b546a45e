"""Judging noisy numbers: steady positions, lasting conditions, improving errors."""

import math

import numpy as np
import pytest

from humanoid_bt.decision.signals import Improving, Lasting, Steady


def test_a_steady_position_has_less_noise_than_what_it_is_given() -> None:
    rng = np.random.default_rng(0)
    steady = Steady(time=0.4)
    seen = [np.array([1.0, 2.0, 3.0]) + rng.normal(0, 0.005, 3) for _ in range(100)]
    given = [steady.update(position, 0.1 * i) for i, position in enumerate(seen)]
    assert np.std(given[20:], axis=0).max() < 0.5 * np.std(seen[20:], axis=0).min()


def test_a_steady_position_follows_a_jump_at_once() -> None:
    steady = Steady(time=0.4, jump=0.04)
    steady.update(np.zeros(3), 0.0)
    np.testing.assert_array_equal(steady.update(np.array([0.05, 0.0, 0.0]), 0.1), [0.05, 0.0, 0.0])


def test_an_observation_counts_once_however_often_it_is_given() -> None:
    steady = Steady(time=0.1)
    steady.update(np.zeros(3), 0.0)
    once = steady.update(np.array([0.02, 0.0, 0.0]), 0.1)
    assert once[0] == pytest.approx(0.01)
    np.testing.assert_array_equal(steady.update(np.array([0.02, 0.0, 0.0]), 0.1), once)


def test_what_is_given_is_not_kept() -> None:
    steady, position = Steady(time=0.1), np.zeros(3)
    steady.update(position, 0.0)
    position[0] = 0.03
    assert steady.update(np.zeros(3), 0.0)[0] == 0


def test_what_is_returned_is_not_kept_either() -> None:
    steady = Steady(time=0.1)
    for _ in range(3):
        aim = steady.update(np.zeros(3), 0.0)
        aim += 0.01
    assert aim[0] == pytest.approx(0.01)


def test_lasting_begins_again_after_a_break() -> None:
    lasting = Lasting(0.5)
    assert [lasting.update(True, t) for t in (0.0, 0.3)] == [False, False]
    assert not lasting.update(False, 0.4)
    assert [lasting.update(True, t) for t in (0.5, 0.9, 1.0)] == [False, False, True]


def test_what_comes_and_goes_is_hopeless_five_tries_after_it_came_first() -> None:
    lasting = Lasting(0.5, patience=1.5)
    seen = {}
    for second in range(3, 20):
        assert not lasting.update(second > 5 and second % 2 == 0, float(second))
        seen[second] = lasting.hopeless
    assert [second for second, hopeless in seen.items() if hopeless] == [17, 18, 19]


@pytest.mark.parametrize("start", [0.02 * tick for tick in range(1, 200, 7)])
def test_lasting_is_as_long_wherever_it_begins(start: float) -> None:
    lasting = Lasting(0.3)
    assert [lasting.update(True, start + 0.02 * tick) for tick in (0, 14, 15)] == [False, False, True]


def test_no_duration_is_at_once() -> None:
    lasting = Lasting(0.0)
    assert not lasting.update(False, 0.0)
    assert lasting.update(True, 0.1)


def test_improving_until_the_patience_is_over() -> None:
    improving = Improving(patience=1.0, step=0.1)
    assert improving.update(3.0, 0.0)
    assert improving.update(2.0, 1.0)
    assert improving.update(1.95, 2.0)  # less than a step smaller
    assert improving.best == 2.0
    assert not improving.update(1.95, 2.1)
    assert improving.update(1.8, 2.2)


def test_an_error_may_grow_after_a_restart() -> None:
    improving = Improving(patience=1.0, step=0.1)
    improving.update(0.0, 0.0)
    improving.restart()
    assert improving.update(5.0, 9.0)
    assert improving.best == 5.0


def test_what_is_small_enough_again_and_again_and_never_for_long_does_not_improve() -> None:
    improving = Improving(patience=1.0, step=0.1)
    improving.update(1.0, 0.0)
    goes_on = []
    for tick in range(1, 60):
        if tick % 2:
            improving.arrived(0.2)
        else:
            goes_on += [improving.update(0.3, 0.1 * tick), improving.update(0.3, 0.1 * tick + 0.05)]
    assert goes_on[:20] == [True] * 20
    assert not goes_on[-1]


def test_no_time_counts_while_the_error_is_small_enough() -> None:
    improving = Improving(patience=1.0, step=0.1)
    improving.update(1.0, 0.0)
    improving.arrived(0.2)
    assert improving.update(0.3, 50.0)
    assert improving.update(0.3, 51.0)
    assert not improving.update(0.3, 51.1)


def test_what_has_moved_on_may_improve_anew() -> None:
    improving = Improving(patience=1.0, step=0.1)
    improving.update(1.0, 0.0)
    improving.update(0.9, 1.0)
    improving.arrived(0.2)
    assert improving.update(2.0, 5.0)
    assert improving.update(1.9, 6.0)
    assert improving.best == 2.0
    assert not improving.update(1.9, 6.1)


def test_what_is_not_a_number_does_not_improve() -> None:
    assert not Improving(patience=1.0, step=0.1).update(math.nan, 0.0)
