"""How long a way is, and how far it turns."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from humanoid_bt.decision.route import Route
from humanoid_bt.robot.config import GaitConfig


@pytest.mark.parametrize(
    ("points", "heading", "length", "turns"),
    [
        ([[0, 0], [2, 0]], 0.0, 2.0, 0.0),
        ([[0, 0], [0, 2]], 0.0, 2.0, math.pi),  # there to the left, and back
        ([[0, 0], [1, 1], [2, 0]], 0.0, 2 * math.sqrt(2), math.pi),
        ([[0, 0], [0, 0.1]], 1.0, 0.1, 1.0),  # it steps aside where that is near
    ],
)
def test_a_way_is_as_long_as_its_parts_and_turns_with_them(
    points: list[list[float]], heading: float, length: float, turns: float
) -> None:
    config = SimpleNamespace(gait=GaitConfig(), walking_radius=0.3)
    robot = SimpleNamespace(config=config, state=SimpleNamespace(stance=np.zeros(3)))
    route = Route(robot)  # type: ignore[arg-type]  # all that it asks a robot for to measure a way
    route._measure(np.array(points, dtype=float), heading)
    assert route.to_go == pytest.approx(length)
    assert route.turns_to_go == pytest.approx(turns)
