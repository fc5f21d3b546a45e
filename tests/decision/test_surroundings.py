"""What is taken for an obstacle from tick to tick, and when a way must be planned anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.surroundings import Surroundings
from tests.tree.helpers import make_robot, make_state


@pytest.mark.parametrize(("size", "named"), [([0.4, 0.4, 0.8], ()), (None, ("cart",))], ids=["solid", "named"])
def test_what_has_gone_is_a_change_and_no_obstacle(size: list[float] | None, named: tuple[str, ...]) -> None:
    robot = make_robot(CycleClock())
    around = Surroundings(robot.handle("walk", ("base",)), named)
    cart = Percept("cart", 0.0, np.array([1.0, 0.0, -0.4]), 0.9, None if size is None else np.array(size))
    seen = []
    for tick, confidence in enumerate((0.9, 0.08, 0.0, 0.0, 0.9)):
        time = 0.02 * tick
        robot.begin_tick(make_state(time), {"cart": replace(cart, stamp=time, confidence=confidence)})
        seen.append((list(around.look().names), around.changes))
    assert seen == [(["cart"], 1), (["cart"], 1), ([], 2), ([], 2), (["cart"], 3)]
