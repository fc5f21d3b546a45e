from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.body import step_timing
from humanoid_bt.control.body.step_timing import Axis, best_time

PLANNED, LEAST = 3.0, 1.6  # tau, a step of 0.28 s and one of 0.12 s


def axis(dcm: float, offset: float = 0.05, least: float = -0.3, most: float = 0.3) -> Axis:
    return Axis(pressure=0.01, dcm=dcm, planned=0.1, offset=offset, least=least, most=most)


AS_PLANNED = axis((0.1 + 0.05 - 0.01) / PLANNED)


def cost(axes: list[Axis], tau: float) -> float:
    """What a time costs, with the best of many footholds for it."""
    whole = step_timing._TIMING_COST * (tau - PLANNED) ** 2
    for one in axes:
        places = np.linspace(one.least, one.most, 6001)
        left = one.pressure + one.dcm * tau - places - one.offset
        whole += float(np.min((places - one.planned) ** 2 + step_timing._OFFSET_COST * left**2))
    return whole


def test_a_dcm_as_planned_leaves_time_and_foothold() -> None:
    tau = best_time([AS_PLANNED, AS_PLANNED], PLANNED, LEAST, PLANNED)
    assert tau == pytest.approx(PLANNED)
    assert AS_PLANNED.place(tau) == pytest.approx(AS_PLANNED.planned)


@pytest.mark.parametrize("seed", range(40))
def test_no_other_time_costs_less(seed: int) -> None:
    """Bounds that hold, and such that do not, among them."""
    numbers = np.random.default_rng(seed)
    axes = [
        Axis(*numbers.uniform([-0.03, -0.15, -0.2, -0.1], [0.03, 0.15, 0.2, 0.1]), least=-0.15, most=float(most))
        for most in numbers.uniform(-0.1, 0.3, 2)
    ]
    tau = best_time(axes, PLANNED, LEAST, 3.5)
    assert LEAST <= tau <= 3.5
    others = np.linspace(LEAST, 3.5, 200)
    assert cost(axes, tau) <= min(cost(axes, float(other)) for other in others) + 1e-5


def test_a_foothold_follows_the_dcm_within_its_bounds() -> None:
    assert axis(0.08).place(2.0) == pytest.approx(0.12, abs=1e-3)  # 0.01 + 0.08 * 2 - 0.05
    assert axis(0.30).place(2.0) == 0.3
    assert axis(-0.30).place(2.0) == -0.3


def test_the_step_is_quick_when_its_foothold_is_out_of_reach() -> None:
    out_of_reach = axis(0.15, most=0.2)
    tau = best_time([AS_PLANNED, out_of_reach], PLANNED, LEAST, PLANNED)
    assert tau == pytest.approx((0.2 + 0.05 - 0.01) / 0.15, abs=0.1)  # when the farthest foothold is the right one
    assert best_time([axis(0.15, most=-0.2)], PLANNED, LEAST, PLANNED) == LEAST
