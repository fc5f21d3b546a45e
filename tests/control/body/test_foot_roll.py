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
DT = 0.0025  # quicker than any robot's control, for smooth curves
SHARES = np.linspace(0.0, 1.0, 101)


def begun(foothold: Array, gait: GaitConfig = GAIT) -> FootRoll:
    return FootRoll(gait, SOLE, DT, START, foothold)


def footing(
    roll: FootRoll,
    share: float,
    yaw: float = 0.0,
    *,
    moved: float = 0.0,
    missed: float = 0.0,
    rate: float = 1.0,
    stops: bool = False,
) -> Array:
    return roll.footing(share, yaw, moved=moved, missed=missed, rate=rate, stops=stops)


def pitches(foothold: Array, gait: GaitConfig = GAIT, **disturbed: float) -> Array:
    """The pitch of a foot that faces along x, over a swing."""
    roll = begun(foothold, gait)
    return np.array([footing(roll, share, **disturbed)[2] for share in SHARES])


def test_a_foot_leaves_by_its_toe_and_lands_by_its_heel_and_is_flat_before_and_after() -> None:
    pitch = pitches(LONGEST)
    assert pitch.max() == pytest.approx(TOE_OFF, abs=0.01)
    assert pitch.min() == pytest.approx(-HEEL_STRIKE, abs=0.01)
    assert pitch.argmax() < 35
    assert pitch.argmin() > 70
    assert pitch[0] == pitch[-1] == 0
    assert np.abs(np.diff(pitch)).max() < 0.04  # no jump


def test_its_lowest_edge_stays_where_a_flat_sole_would_be() -> None:
    roll = begun(LONGEST)
    for share in SHARES:
        higher, _, pitch = footing(roll, share)
        assert higher == pytest.approx(SOLE.half_length * math.sin(abs(pitch)), abs=1e-12)


def test_it_rolls_about_its_own_axis() -> None:
    share, yaw = 0.28, 2.0
    _, x, y = footing(begun(LONGEST), share, yaw)
    assert math.cos(yaw) * x + math.sin(yaw) * y == pytest.approx(0.0, abs=1e-12)
    assert -math.sin(yaw) * x + math.cos(yaw) * y > 0.3


@pytest.mark.parametrize("foothold", [(-0.2, 0.0, 0.0), (0.0, 0.1, 0.0), (0.4, 0.0, GAIT.step_turn)])
def test_a_step_back_or_aside_or_that_turns_is_flat(foothold: tuple[float, float, float]) -> None:
    np.testing.assert_allclose(pitches(np.array(foothold)), 0.0, atol=1e-12)


def test_a_stride_is_long_straight_and_undisturbed() -> None:
    assert begun(LONGEST).stride == 1.0
    assert begun(LONGEST, GaitConfig()).stride == 1.0  # of a robot that walks on flat feet, too
    assert begun(LONGEST / 2).stride == pytest.approx(0.5)
    assert begun(np.array([*LONGEST[:2], GAIT.step_turn / 2])).stride == pytest.approx(0.5)
    assert begun(np.array([-0.2, 0.0, 0.0])).stride == 0.0
    roll = begun(LONGEST)
    strides = [(footing(roll, 0.5, missed=0.03), roll.stride)[1] for _ in range(30)]
    assert strides[0] == pytest.approx(1 - DT / 0.02)
    assert strides[-1] < 0.05
    footing(roll, 0.5)
    assert roll.stride > 0.1


def test_a_short_step_rolls_less() -> None:
    np.testing.assert_allclose(pitches(LONGEST / 2), pitches(LONGEST) / 2)


def test_a_foot_that_lands_elsewhere_leaves_by_its_toe_and_lands_flat() -> None:
    np.testing.assert_array_equal(pitches(LONGEST, moved=0.02), pitches(LONGEST))
    elsewhere = pitches(LONGEST, moved=0.12)
    assert elsewhere.max() == pytest.approx(TOE_OFF, abs=0.01)
    np.testing.assert_allclose(elsewhere[80:], 0.0, atol=1e-3)


def test_a_robot_that_is_stopped_comes_to_stand_on_flat_feet() -> None:
    roll = begun(LONGEST)
    pitch = [footing(roll, share, stops=share > 0.75)[2] for share in SHARES]
    assert min(pitch[:76]) < -0.1
    assert np.abs(pitch[90:]).max() < 0.02
    assert np.abs(np.diff(pitch)).max() < 0.04
    np.testing.assert_allclose([footing(begun(LONGEST), share, stops=True)[2] for share in SHARES[:5]], 0.0, atol=0.02)


@pytest.mark.parametrize(
    ("some", "all_of_it"), [({"missed": 0.015}, {"missed": 0.03}), ({"rate": 1.15}, {"rate": 1.4})]
)
def test_a_foot_that_catches_a_push_stays_flat(some: dict[str, float], all_of_it: dict[str, float]) -> None:
    calm = pitches(LONGEST)
    np.testing.assert_allclose(pitches(LONGEST, **some)[50:], calm[50:] / 2, atol=1e-3)
    np.testing.assert_allclose(pitches(LONGEST, **all_of_it)[50:], 0.0, atol=1e-3)


def test_a_foot_that_is_disturbed_in_the_air_lies_flat_soon_and_without_a_jump() -> None:
    roll = begun(LONGEST)
    pitch = [footing(roll, share, rate=1.0 if share < 0.8 else 1.5)[2] for share in SHARES]
    assert min(pitch) == pytest.approx(-HEEL_STRIKE, abs=0.01)
    assert np.abs(pitch[90:]).max() < 0.05
    assert np.abs(np.diff(pitch)).max() < 0.04


def test_feet_of_a_robot_that_does_not_say_stay_flat() -> None:
    np.testing.assert_array_equal(pitches(LONGEST, gait=GaitConfig()), 0.0)
