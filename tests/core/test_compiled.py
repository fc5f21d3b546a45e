"""What is compiled does the same as the Python function that it was made from."""

from __future__ import annotations

import math

import numpy as np

from humanoid_bt.core.compiled import compiled


def test_arithmetic_is_numpys() -> None:
    @compiled("f8(f8, f8)")
    def share(part: float, whole: float) -> float:
        return part / whole

    assert share(1.0, 4.0) == 0.25
    assert math.isinf(share(1.0, 0.0))
    assert math.isnan(share(0.0, 0.0))


def test_nothing_is_reordered() -> None:
    @compiled("f8(f8[::1])")
    def total(values: np.ndarray) -> float:
        found = 0.0
        for value in values:
            found += value
        return found

    values = np.random.default_rng(3).normal(size=999) * 10.0 ** np.arange(999)[::-1].clip(0, 12)
    one_by_one = 0.0
    for value in values.tolist():
        one_by_one += value
    assert total(values) == one_by_one
