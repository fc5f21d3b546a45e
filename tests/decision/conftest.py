from __future__ import annotations

import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.decision.robot import Robot
from tests.tree.helpers import make_robot


@pytest.fixture
def clock() -> CycleClock:
    return CycleClock()


@pytest.fixture
def robot(clock: CycleClock) -> Robot:
    return make_robot(clock)
