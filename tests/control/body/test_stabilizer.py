from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.planar import seen_from
from humanoid_bt.control.body.stabilizer import Load, Stabilizer
from humanoid_bt.control.dynamics import GRAVITY
from humanoid_bt.core.messages import SIDES
from humanoid_bt.robot.config import GaitConfig, SoleConfig

GAIT = GaitConfig()
SOLE = SoleConfig(half_length=0.105, half_width=0.045)
MASS, DT, HEIGHT = 40.0, 0.005, 0.65
SOLES = {"left": np.array([0.02, 0.09, 0.1]), "right": np.array([-0.02, -0.09, -0.1])}
BOTH = {"left": True, "right": True}
CENTRE = np.array([0.0, 0.0, HEIGHT])


@pytest.fixture
def stabilizer() -> Stabilizer:
    stabilizer = Stabilizer(GAIT, SOLE, MASS, DT)
    stabilizer.reset(CENTRE)
    return stabilizer


def update(stabilizer: Stabilizer, **given: Any) -> Load:
    at_rest = {
        "com": CENTRE, "dcm": np.zeros(2), "dcm_reference": np.zeros(2), "zmp_reference": np.zeros(2),
        "lean": np.zeros(2), "momentum_rate": np.zeros(3), "soles": SOLES, "contact": BOTH,
    }  # fmt: skip
    return stabilizer.update(**{**at_rest, **given})


def test_both_references_give_way_to_a_lean_by_half_of_it() -> None:
    one, other = (Stabilizer(GAIT, SOLE, MASS, DT) for _ in range(2))
    for stabilizer in (one, other):
        stabilizer.reset(CENTRE)
    leans = update(one, lean=np.array([0.02, -0.01]))
    moved = update(other, dcm_reference=np.array([0.01, -0.005]), zmp_reference=np.array([-0.01, 0.005]))
    np.testing.assert_allclose(leans.zmp, moved.zmp, atol=1e-12)
    np.testing.assert_allclose(one.com_reference, other.com_reference, atol=1e-12)
    assert leans.zmp[0] != update(other).zmp[0]


def test_at_rest_both_feet_carry_half_and_nothing_pushes(stabilizer: Stabilizer) -> None:
    load = update(stabilizer)
    np.testing.assert_allclose(load.share, 0.5)
    np.testing.assert_allclose(load.zmp, [0, 0], atol=1e-12)
    np.testing.assert_allclose(load.force, [0, 0, MASS * GRAVITY], atol=1e-9)


def test_without_an_error_the_zmp_is_its_reference(stabilizer: Stabilizer) -> None:
    reference = np.array([0.03, 0.05])
    load = update(stabilizer, zmp_reference=reference, dcm=np.array([0.01, 0.02]), dcm_reference=np.array([0.01, 0.02]))
    np.testing.assert_allclose(load.zmp, reference, atol=1e-9)


@pytest.mark.parametrize("error", [[0.01, 0], [-0.01, 0], [0, 0.01], [0, -0.01]])
def test_the_zmp_overtakes_the_dcm_so_that_the_force_drives_it_back(stabilizer: Stabilizer, error: list[float]) -> None:
    off = np.array(error)
    load = update(stabilizer, dcm=off, com=CENTRE)
    np.testing.assert_allclose(load.zmp, GAIT.dcm_gain * off, atol=1e-9)
    assert load.force[:2] @ off < 0


def test_it_brings_a_moving_pendulum_to_rest(stabilizer: Stabilizer) -> None:
    com, velocity = CENTRE.copy(), np.array([0.12, -0.10])
    for _ in range(round(2.0 / DT)):
        load = update(stabilizer, com=com, dcm=com[:2] + velocity / stabilizer.omega)
        velocity = velocity + load.force[:2] / MASS * DT
        com[:2] += velocity * DT
    np.testing.assert_allclose([*com[:2], *velocity], np.zeros(4), atol=2e-3)


def test_shares_add_up_and_pressure_stays_inside_the_soles(stabilizer: Stabilizer) -> None:
    numbers = np.random.default_rng(0)
    for _ in range(200):
        contact = [BOTH, {"left": True, "right": False}, {"left": False, "right": True}][numbers.integers(3)]
        dcm, zmp_reference = numbers.uniform(-0.3, 0.3, (2, 2))
        load = update(stabilizer, dcm=dcm, zmp_reference=zmp_reference, contact=contact)
        assert load.share.sum() == pytest.approx(1)
        np.testing.assert_allclose(load.zmp, load.share @ load.cop)
        for side, share, cop in zip(SIDES, load.share, load.cop, strict=True):
            assert 0 <= share <= 1
            assert contact[side] or share == 0
            x, y = np.abs(seen_from(SOLES[side], cop))
            assert x <= SOLE.half_length - SOLE.margin + 1e-9
            assert y <= SOLE.half_width - SOLE.margin + 1e-9
        assert load.force[2] == pytest.approx(MASS * GRAVITY)


def test_the_foot_toward_which_the_robot_falls_carries_more(stabilizer: Stabilizer) -> None:
    assert update(stabilizer, dcm=np.array([0, 0.02])).share[0] > 0.6
    assert update(stabilizer, dcm=np.array([0, -0.02])).share[1] > 0.6


def test_angular_momentum_shifts_the_zmp_within_its_limit_but_not_the_force(stabilizer: Stabilizer) -> None:
    load = update(stabilizer, momentum_rate=np.array([4.0, -8.0, 0]))
    np.testing.assert_allclose(load.zmp, np.array([8.0, 4.0]) / (MASS * GRAVITY), atol=1e-9)
    np.testing.assert_allclose(load.force[:2], [0, 0], atol=1e-9)
    wide = {side: sole * [1, 3, 0] for side, sole in SOLES.items()}
    load = update(stabilizer, momentum_rate=np.array([1e4, 0, 0]), soles=wide)
    assert load.zmp[1] == pytest.approx(GAIT.momentum_limit)
    stride = {side: sole * [10, 1, 0] for side, sole in SOLES.items()}
    load = update(stabilizer, momentum_rate=np.array([0, -1e4, 0]), soles=stride)
    assert load.zmp[0] == pytest.approx(GAIT.momentum_limit)


def test_the_reference_of_the_centre_of_mass_goes_to_the_dcm(stabilizer: Stabilizer) -> None:
    goal = np.array([0.05, -0.03])
    for _ in range(round(3.0 / DT)):
        reference = stabilizer.com_reference
        update(stabilizer, dcm_reference=goal, com=np.array([*reference, HEIGHT]))
    np.testing.assert_allclose(stabilizer.com_reference, goal, atol=1e-3)


def test_the_reference_of_the_centre_of_mass_slides_to_where_that_is(stabilizer: Stabilizer) -> None:
    for _ in range(round(3.0 / DT)):
        update(stabilizer, com=np.array([0.05, 0.0, HEIGHT]))
    share = GAIT.com_slide / (GAIT.com_slide + stabilizer.omega)
    np.testing.assert_allclose(stabilizer.com_reference, [0.05 * share, 0.0], atol=1e-6)


def test_omega_is_that_of_a_pendulum_of_the_robots_height(stabilizer: Stabilizer) -> None:
    assert stabilizer.omega == pytest.approx(np.sqrt(9.81 / HEIGHT))
