from __future__ import annotations

import math

import numpy as np
import pytest

from humanoid_bt.control.body.body import Footstep
from humanoid_bt.control.body.dcm import plan_dcm, plan_settle, plan_walk
from humanoid_bt.robot.config import GaitConfig

GAIT = GaitConfig()
OMEGA, DT = 3.9, 0.005
RIGHT = np.array([0.0, -0.09, 0.0])
STEPS = [Footstep("left", np.array([0.15, 0.09, 0.0])), Footstep("right", np.array([0.30, -0.09, 0.0]))]


def test_a_constant_zmp_is_a_dcm_at_rest() -> None:
    zmp = np.tile([0.3, -0.2], (50, 1))
    np.testing.assert_allclose(plan_dcm(zmp, OMEGA, DT), zmp, atol=1e-12)


def test_before_a_jump_of_the_zmp_the_dcm_has_its_closed_form() -> None:
    first, last = np.array([0.0, 0.1]), np.array([0.2, -0.1])
    zmp = np.vstack([np.tile(first, (70, 1)), np.tile(last, (30, 1))])
    to_the_jump = (70 - np.arange(70)) * DT
    expected = first + (last - first) * np.exp(-OMEGA * to_the_jump)[:, None]
    dcm = plan_dcm(zmp, OMEGA, DT)
    np.testing.assert_allclose(dcm[:70], expected, atol=1e-12)
    np.testing.assert_allclose(dcm[70:], zmp[70:], atol=1e-12)


def test_a_walk_obeys_the_dynamics_of_the_dcm() -> None:
    plan = plan_walk(GAIT, OMEGA, DT, zmp=np.zeros(2), support=RIGHT, shift=0.8, steps=STEPS)
    exact = plan.zmp[:-1] + (plan.dcm[:-1] - plan.zmp[:-1]) * math.exp(OMEGA * DT)
    np.testing.assert_allclose(plan.dcm[1:], exact, atol=1e-9)
    rate = (plan.dcm[1:] - plan.dcm[:-1]) / DT
    np.testing.assert_allclose(rate, OMEGA * (plan.dcm[:-1] - plan.zmp[:-1]), rtol=0.02, atol=1e-6)


def test_a_walk_ends_at_rest_between_the_last_feet() -> None:
    plan = plan_walk(GAIT, OMEGA, DT, zmp=np.zeros(2), support=RIGHT, shift=0.8, steps=STEPS)
    np.testing.assert_allclose(plan.zmp[-1], [0.225, 0], atol=1e-12)
    np.testing.assert_allclose(plan.dcm[-1], plan.zmp[-1], atol=1e-12)


def test_the_zmp_is_under_the_foot_that_carries() -> None:
    plan = plan_walk(GAIT, OMEGA, DT, zmp=np.zeros(2), support=RIGHT, shift=0.8, steps=STEPS)
    shift, single, double = round(0.8 / DT), round(GAIT.single_support / DT), round(GAIT.double_support / DT)
    np.testing.assert_allclose(plan.zmp[shift : shift + single], np.tile(RIGHT[:2], (single, 1)))
    left = slice(shift + single + double, shift + 2 * single + double)
    np.testing.assert_allclose(plan.zmp[left], np.tile(STEPS[0].pose[:2], (single, 1)))


@pytest.mark.parametrize("start", [np.zeros(2), np.array([0.05, 0.02])])
def test_the_zmp_never_jumps(start: np.ndarray) -> None:
    plan = plan_walk(GAIT, OMEGA, DT, zmp=start, support=RIGHT, shift=0.1, steps=STEPS)
    moves = np.linalg.norm(np.diff(np.vstack([start, plan.zmp]), axis=0), axis=1)
    assert moves.max() < 0.3 / GAIT.double_support * DT


@pytest.mark.parametrize("begins", [np.zeros(2), np.array([0.0, -0.005])])
def test_the_first_step_begins_with_the_dcm_where_it_is(begins: np.ndarray) -> None:
    jumps = plan_walk(GAIT, OMEGA, DT, zmp=begins, support=RIGHT, shift=0.55, steps=STEPS)
    plan = plan_walk(GAIT, OMEGA, DT, zmp=begins, support=RIGHT, shift=0.55, steps=STEPS, begins=begins)
    assert jumps.dcm[0, 1] < begins[1] - 0.02
    assert plan.dcm[0, 1] == pytest.approx(begins[1], abs=1e-9)
    exact = plan.zmp[:-1] + (plan.dcm[:-1] - plan.zmp[:-1]) * math.exp(OMEGA * DT)
    np.testing.assert_allclose(plan.dcm[1:], exact, atol=1e-9)
    shifted = round(0.55 / DT)
    np.testing.assert_allclose(plan.zmp[shifted:], jumps.zmp[shifted:], atol=1e-12)


def test_a_quick_weight_shift_leaves_both_feet_on_the_ground() -> None:
    plan = plan_walk(GAIT, OMEGA, DT, zmp=np.zeros(2), support=RIGHT, shift=0.2, steps=STEPS, begins=np.zeros(2))
    assert 0.05 < plan.zmp[0, 1] < 0.09, "most of the weight on the left foot, not all of it"


def test_no_weight_goes_to_the_foot_that_swings_where_the_dcm_is_near_the_other_one_already() -> None:
    given = {"zmp": np.zeros(2), "support": RIGHT, "shift": 0.55, "steps": STEPS}
    plan, jumps = (plan_walk(GAIT, OMEGA, DT, **given, begins=begins) for begins in (RIGHT[:2], None))  # type: ignore[arg-type]  # of several types
    np.testing.assert_array_equal(plan.zmp, jumps.zmp)


def test_settling_ends_at_rest_over_the_middle() -> None:
    plan = plan_settle(GAIT, OMEGA, DT, zmp=np.array([0.1, -0.09]), middle=np.array([0.15, 0.0]))
    assert len(plan) == len(plan.zmp) == len(plan.dcm)
    np.testing.assert_allclose(plan.dcm[-1], [0.15, 0.0], atol=1e-12)
    ramp = round(GAIT.last_shift / DT)
    np.testing.assert_allclose(plan.zmp[ramp - 1 :], np.tile([0.15, 0.0], (len(plan) - ramp + 1, 1)), atol=1e-12)
