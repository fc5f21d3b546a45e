"""How far the base may sink in a control period."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.control.body.height_limit import HeightLimit


@pytest.mark.parametrize(
    ("height", "period", "sinks"), [(0.6, 0.01, 0.01), (0.6, 0.5, 0.1), (0.5, 0.01, 0.0), (0.4, 0.01, 0.0)]
)
def test_the_base_comes_to_rest_above_its_lowest_height_and_may_always_rise(
    height: float, period: float, sinks: float
) -> None:
    limit = HeightLimit(8)
    limit.lowest = 0.5
    configuration: Any = SimpleNamespace(data=SimpleNamespace(qpos=np.array([1.0, 2.0, height])))
    found = limit.compute_qp_inequalities(configuration, period)
    for way, allowed in ((sinks, True), (sinks + 1e-3, False), (-1.0, True)):
        moves = np.full(8, 9.0)
        moves[2] = -way
        assert bool((found.G @ moves <= found.h + 1e-12).all()) == allowed
