from __future__ import annotations

import math

import numpy as np
import pytest

from humanoid_bt.control.body import step_timing
from humanoid_bt.control.body.step_timing import Axis, Pace, best_place

PLANNED, LEAST = 3.0, 1.6  # tau, a step of 0.28 s and one of 0.12 s
OMEGA = 3.9
QUICKLY = Pace(PLANNED, OMEGA, 100.0)  # a foot that gets everywhere in time


def best_time(*axes: Axis, most: float = PLANNED, pace: Pace = QUICKLY) -> float:
    return step_timing.best_time((axes[0], axes[-1]), LEAST, most, pace)


def in_reach(reach: float) -> Pace:
    """Of a foot that gets so far [m] until tau is 2."""
    return Pace(PLANNED, OMEGA, reach * OMEGA / math.log(2.0))


def axis(dcm: float, offset: float = 0.05, least: float = -0.3, most: float = 0.3, foot: float = 0.0) -> Axis:
    return Axis(pressure=0.01, dcm=dcm, planned=0.1, offset=offset, least=least, most=most, foot=foot)


AS_PLANNED = axis((0.1 + 0.05 - 0.01) / PLANNED)


def cost(axes: tuple[Axis, Axis], tau: float, speed: float) -> float:
    """What a time costs, with the best of many footholds that the foot can reach until then."""
    whole, reach = step_timing._TIMING_COST * (tau - PLANNED) ** 2, speed * math.log(tau) / OMEGA
    for one in axes:
        places = np.linspace(one.least, one.most, 6001)
        near = places[np.abs(places - one.foot) <= reach + 1e-4]
        places = near if near.size else places[[np.argmin(np.abs(places - one.foot))]]
        left = one.pressure + one.dcm * tau - places - one.offset
        whole += float(np.min((places - one.planned) ** 2 + step_timing._OFFSET_COST * left**2))
    return whole


def test_a_dcm_as_planned_leaves_time_and_foothold() -> None:
    tau = best_time(AS_PLANNED)
    assert tau == pytest.approx(PLANNED)
    assert best_place(AS_PLANNED, tau, QUICKLY) == pytest.approx(AS_PLANNED.planned)


@pytest.mark.parametrize("speed", [0.5, 1.5, QUICKLY.speed])
@pytest.mark.parametrize("seed", range(20))
def test_no_other_time_costs_less(seed: int, speed: float) -> None:
    """Bounds that hold, and such that do not, among them."""
    numbers = np.random.default_rng(seed)
    ahead, aside = (
        Axis(
            *numbers.uniform([-0.03, -0.15, -0.2, -0.1], [0.03, 0.15, 0.2, 0.1]), least=-0.15, most=float(most), foot=0
        )
        for most in numbers.uniform(-0.1, 0.3, 2)
    )
    axes = ahead, aside
    tau = best_time(*axes, most=3.5, pace=Pace(PLANNED, OMEGA, speed))
    assert LEAST <= tau <= 3.5
    others = np.linspace(LEAST, 3.5, 200)
    assert cost(axes, tau, speed) <= 1.02 * min(cost(axes, float(other), speed) for other in others) + 1e-4


def test_a_foothold_follows_the_dcm_within_its_bounds() -> None:
    assert best_place(axis(0.08), 2.0, QUICKLY) == pytest.approx(0.12, abs=1e-3)  # 0.01 + 0.08 * 2 - 0.05
    assert best_place(axis(0.30), 2.0, QUICKLY) == 0.3
    assert best_place(axis(-0.30), 2.0, QUICKLY) == -0.3


def test_a_foothold_is_where_the_foot_gets_in_time() -> None:
    assert best_place(axis(0.08, foot=-0.1), 2.0, in_reach(0.15)) == pytest.approx(0.05)
    assert best_place(axis(-0.30, foot=0.2), 2.0, in_reach(0.15)) == pytest.approx(0.05)
    assert best_place(axis(0.08, least=0.2, foot=-0.1), 2.0, in_reach(0.15)) == 0.2  # nearer than that it must not be


def test_the_step_is_quick_when_its_foothold_is_out_of_reach() -> None:
    out_of_reach = axis(0.15, most=0.2)
    tau = best_time(AS_PLANNED, out_of_reach)
    assert tau == pytest.approx((0.2 + 0.05 - 0.01) / 0.15, abs=0.1)  # when the farthest foothold is the right one
    assert best_time(axis(0.15, most=-0.2)) == pytest.approx(LEAST)


def test_a_long_step_becomes_a_short_one_when_it_must_be_quick() -> None:
    """A robot that walks ahead is pushed beyond the foot it stands on."""
    ahead, aside = axis(0.05, foot=-0.2), axis(0.15, most=-0.1)
    slowly = Pace(PLANNED, OMEGA, 1.5)
    tau = best_time(ahead, aside, pace=slowly)
    assert tau < 1.8
    assert best_place(ahead, tau, slowly) < 0.04 < best_place(ahead, PLANNED, QUICKLY)
