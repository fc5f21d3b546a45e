from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.control.body.foot_roll import FootRoll
from humanoid_bt.core.messages import Array
from humanoid_bt.robot.config import GaitConfig, SoleConfig

TOE_OFF, HEEL_STRIKE = 0.4, 0.2
GAIT = replace(GaitConfig(), toe_off=TOE_OFF, heel_strike=HEEL_STRIKE)
SOLE = SoleConfig(half_length=0.105, half_width=0.045)
START = np.zeros(3)
LONGEST = np.array([2 * GAIT.step_forward, 0.0, 0.0])
SHARES = np.linspace(0.0, 1.0, 101)


def pitches(foothold: Array, moved: float = 0.0, gait: GaitConfig = GAIT) -> Array:
    """The pitch of a foot that faces along x, over a swing."""
    roll = FootRoll(gait, SOLE, START, foothold)
    return np.array([roll.footing(share, 0.0, moved)[2] for share in SHARES])


def test_a_foot_leaves_by_its_toe_and_lands_by_its_heel_and_is_flat_before_and_after() -> None:
    pitch = pitches(LONGEST)
    assert pitch.max() == pytest.approx(TOE_OFF, abs=0.01)
    assert pitch.min() == pytest.approx(-HEEL_STRIKE, abs=0.01)
    assert pitch.argmax() < 30
    assert pitch.argmin() > 70
    assert pitch[0] == pitch[-1] == 0
    assert np.abs(np.diff(pitch)).max() < 0.04  # no jump


def test_its_lowest_edge_stays_where_a_flat_sole_would_be() -> None:
    roll = FootRoll(GAIT, SOLE, START, LONGEST)
    for share in SHARES:
        higher, _, pitch = roll.footing(share, 0.0, 0.0)
        assert higher == pytest.approx(SOLE.half_length * math.sin(abs(pitch)), abs=1e-12)


def test_it_rolls_about_its_own_axis() -> None:
    share, yaw = 0.2, 2.0
    _, x, y = FootRoll(GAIT, SOLE, START, LONGEST).footing(share, yaw, 0.0)
    assert math.cos(yaw) * x + math.sin(yaw) * y == pytest.approx(0.0, abs=1e-12)
    assert -math.sin(yaw) * x + math.cos(yaw) * y > 0.3


@pytest.mark.parametrize("foothold", [(-0.2, 0.0, 0.0), (0.0, 0.1, 0.0), (0.4, 0.0, GAIT.step_turn)])
def test_a_step_back_or_aside_or_that_turns_is_flat(foothold: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(pitches(np.array(foothold)), 0.0, atol=1e-12)


def test_a_short_step_rolls_less() -> None:
    np.testing.assert_allclose(pitches(LONGEST / 2), pitches(LONGEST) / 2)


def test_a_step_that_catches_a_push_lands_flat() -> None:
    np.testing.assert_array_equal(pitches(LONGEST, moved=0.02), pitches(LONGEST))
    np.testing.assert_array_equal(pitches(LONGEST, moved=0.12), 0.0)


def test_feet_of_a_robot_that_does_not_say_stay_flat() -> None:
    np.testing.assert_array_equal(pitches(LONGEST, gait=GaitConfig()), 0.0)
