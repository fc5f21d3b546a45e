"""What a skill says of its robot: why a hand is turned no nearer, why no step is made, what touched an arm."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.messages import RESOURCES, Contact, Mode
from humanoid_bt.decision.anatomy import ArmJoint
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from tests.tree.helpers import make_state


def handle_in(robot: Robot, **state: Any) -> RobotHandle:
    """Return the handle of a skill on a robot in such a state."""
    robot.begin_tick(replace(make_state(), **state), {})
    return RobotHandle(robot, "t/reach", RESOURCES)


TOUCHED = Contact(np.zeros(3), 43.0, yields=True)


@pytest.mark.parametrize(
    ("angles", "state", "why"),
    [
        ([0.0, 0.0], {}, ""),
        ([0.96, -0.96], {}, ""),
        ([0.0, 0.98], {}, ": elbow is at its limit"),
        ([-0.98, 0.0], {}, ": shoulder is at its limit"),
        ([-0.98, 0.98], {}, ": shoulder and elbow are at their limits"),
        ([0.0, 0.0], {"hand_obstacles": {"left": "right_forearm"}}, ": the right forearm is in the way"),
        ([0.0, 0.0], {"hand_obstacles": {"right": "left_forearm"}}, ""),
        ([0.98, 0.0], {"hand_obstacles": {"left": "right_forearm"}}, ": shoulder is at its limit"),
    ],
)
def test_a_palm_is_turned_no_nearer_for_a_limit_before_what_is_in_the_way(
    robot: Robot, monkeypatch: pytest.MonkeyPatch, angles: list[float], state: dict[str, Any], why: str
) -> None:
    joints = {name: ArmJoint(angle, -1.0, 1.0) for name, angle in zip(("shoulder", "elbow"), angles, strict=True)}
    monkeypatch.setattr(RobotHandle, "arm_joints", lambda *_: joints)
    handle = handle_in(robot, **state)
    assert handle.why_not_turned("left", math.radians(12)) == f"left hand turns no nearer than 12 deg{why}"
    handle = handle_in(robot, **state, contacts={"left_arm": TOUCHED})
    assert handle.why_not_turned("left", 0.2) == "left arm touched something: 43 N"


@pytest.mark.parametrize(
    ("settled", "mode", "stands"),
    [(True, Mode.RUN, True), (False, Mode.RUN, False), (True, Mode.PAUSED, False), (True, Mode.EMERGENCY_STOP, False)],
)
def test_no_step_is_made_by_a_base_that_stands_and_is_not_stopped(
    robot: Robot, settled: bool, mode: Mode, stands: bool
) -> None:
    said = handle_in(robot, base_settled=settled, mode=mode).why_no_step()
    assert said == (", for which it makes no step" if stands else "")


def test_only_an_arm_that_yields_was_touched(robot: Robot) -> None:
    handle = handle_in(robot, contacts={"left_arm": replace(TOUCHED, yields=False), "right_arm": TOUCHED})
    assert (handle.touched("left"), handle.touched("right")) == ("", "right arm touched something: 43 N")
    assert handle_in(robot).touched("right") == ""
