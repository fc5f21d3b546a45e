"""Which body a robot has."""

from __future__ import annotations

from humanoid_bt.control.body.body import Body
from humanoid_bt.control.body.own import own_body
from humanoid_bt.control.body.policy.learned_body import LearnedBody
from humanoid_bt.control.body.whole_body import WholeBody
from humanoid_bt.control.body.yielding import Felt
from humanoid_bt.control.dynamics import RobotDynamics
from humanoid_bt.robot.model import RobotModel


def bodies(robot: RobotModel, dynamics: RobotDynamics, contact: Felt, *, waits: bool) -> list[Body]:
    """Return the body that ``robot.yaml`` asks for, and those that take its place, one after the other, if it fails.

    Args:
        robot: the robot.
        dynamics: as it is estimated, always up to date.
        contact: what touches it, likewise.
        waits: whether time stands still while a body computes.
    """
    model_based = WholeBody(robot, dynamics, contact)
    if robot.config.body.walk == "own":
        return [own_body(robot, dynamics, contact), model_based]
    if robot.policy is None:
        return [model_based]
    return [LearnedBody(robot, robot.policy, dynamics, contact, waits=waits), model_based]
