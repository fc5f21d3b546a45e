from __future__ import annotations

import math

import numpy as np
import pytest

from humanoid_bt.control.body.support import beyond, shared
from humanoid_bt.core.messages import Array, Side

HALF = np.array([0.1, 0.04])
TURNED: dict[Side, Array] = {  # long side along the world's y
    "left": np.array([1.0, 0.0, math.pi / 2]),
    "right": np.array([1.2, 0.0, math.pi / 2]),
}


@pytest.mark.parametrize(("wanted", "borne"), [([1.01, 0.05], [1.01, 0.05]), ([2.0, -3.0], [1.04, -0.1])])
def test_a_foot_alone_bears_what_is_inside_of_its_sole(wanted: list[float], borne: list[float]) -> None:
    cop = np.empty((2, 2))
    assert shared(*wanted, TURNED["left"], TURNED["right"], True, False, HALF, cop) == 0.0
    np.testing.assert_allclose(cop[0], borne, atol=1e-12)


@pytest.mark.parametrize(
    ("wanted", "borne"),
    [
        ([1.05, 0.02], [1.05, 0.02]),
        ([1.1, 0.3], [1.1, 0.1]),
        ([1.23, 0.0], [1.23, 0.0]),
        ([2.0, 0.0], [1.24, 0.0]),
    ],
)
def test_two_feet_share_what_lies_between_them(wanted: list[float], borne: list[float]) -> None:
    cop = np.empty((2, 2))
    on_right = shared(*wanted, TURNED["left"], TURNED["right"], True, True, HALF, cop)
    np.testing.assert_allclose((1 - on_right) * cop[0] + on_right * cop[1], borne, atol=1e-12)
    assert beyond(np.array(wanted), TURNED, HALF) == pytest.approx(math.dist(wanted, borne))
