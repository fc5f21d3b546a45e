"""The joints of the arms, as far as somebody commands them by name."""

from __future__ import annotations

import math
from collections.abc import Mapping

from humanoid_bt.core.errors import nearest
from humanoid_bt.core.messages import SIDES, Side
from humanoid_bt.robot.model import RobotModel

Arms = Mapping[Side, Mapping[str, tuple[float, float]]]
"""Side -> joint -> soft limits [rad]: from the shoulder to the hand."""


def arms_of(robot: RobotModel) -> Arms:
    """Return the joints of a robot's arms; a robot without hands has no arms."""
    lower, upper = robot.lower.tolist(), robot.upper.tolist()
    return {
        side: {robot.joint_names[j]: (lower[j], upper[j]) for j in robot.arm_joints(side)}
        for side in SIDES
        if side in robot.config.hands
    }


def joints_fault(arms: Arms, side: Side, joints: Mapping[str, float]) -> str:
    """Return what is wrong with angles [rad] asked of an arm's joints, "" for nothing.

    It goes on from "a target of the left arm": ``asks 1.2 rad of 'left_elbow', whose limits are -2.28 to -0.02 rad``.
    """
    own = arms.get(side, {})
    if not joints:
        return "names no joint"
    for name, angle in joints.items():
        if name not in own:
            other = next((of for of, names in arms.items() if name in names), None)
            what = f"a joint of the {other} arm" if other else f"which is no joint of the {side} arm"
            return f"names {name!r}, {what}; {nearest(str(name), own) or 'it has none'}"
        low, high = own[name]
        if not math.isfinite(angle):
            return f"asks for what is not finite: {angle} rad of {name!r}"
        if not low <= angle <= high:
            return f"asks {angle:g} rad of {name!r}, whose limits are {low:.2f} to {high:.2f} rad"
    return ""


def speed_fault(speed: float | None) -> str:
    """Return what is wrong with the speed of a motion, "" for nothing."""
    if speed is None or (math.isfinite(speed) and speed > 0):
        return ""
    return f"has the speed {speed}, which is not above 0" if math.isfinite(speed) else "has a speed that is not finite"
