"""What a robot that stands knows of its surroundings, after it has looked for a while."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from humanoid_bt.core.clock import CycleClock, cycles
from humanoid_bt.core.messages import Percept
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.decision.surroundings import Surroundings
from tests.tree.helpers import make_robot, make_state


def watched(seen: Callable[[float], Sequence[Percept]], until: float) -> Surroundings:
    """Return what is known of things that perception has shown ten times a second."""
    robot = make_robot(clock := CycleClock())
    around = Surroundings(RobotHandle(robot, "walk", ("base",)))
    for tick in range(round(until * 10) + 1):
        clock.cycle = cycles(0.1 * tick)
        robot.begin_tick(make_state(tick / 10), {percept.name: percept for percept in seen(tick / 10)})
        around.look()
    return around
