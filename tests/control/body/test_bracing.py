from __future__ import annotations

import numpy as np
import pytest

from humanoid_bt.control.body.bracing import Bracing
from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.core.messages import SIDES, Array, Estimate, HandTarget, Target
from humanoid_bt.robot.model import RobotModel

DT = 0.005
WALL = np.array([-40.0, 0.0, 0.0])
PRESSING = {"right_hand": HandTarget(np.array([1.0, 0.0, 1.0]), press=40.0)}


@pytest.fixture
def dynamics(robot: RobotModel, estimate: Estimate) -> RobotDynamics:
    dynamics = RobotDynamics(robot)
    dynamics.update(estimate)
    return dynamics


def lean(
    robot: RobotModel, dynamics: RobotDynamics, targets: dict[str, Target], force: Array, *, yields: bool = False
) -> Array:
    """Return what it leans in the end."""
    bracing = Bracing(robot.mass, dynamics, DT)
    for _ in range(1000):
        bracing.update(
            targets,
            {"left_arm": np.zeros(3), "right_arm": force},
            {"right"} if yields else (),
            np.zeros(2),
            0.0,
        )
    return bracing.lean


def test_it_leans_against_what_it_presses_on(robot: RobotModel, dynamics: RobotDynamics) -> None:
    palm, weight = dynamics.palm("right"), robot.mass * GRAVITY
    np.testing.assert_allclose(lean(robot, dynamics, PRESSING, WALL), [40 * palm[2] / weight, 0], atol=1e-6)
    table = lean(robot, dynamics, PRESSING, np.array([0.0, 0.0, 40.0]))
    np.testing.assert_allclose(table, 40 * palm[:2] / weight, atol=1e-6)


def test_it_leans_against_nothing_else(robot: RobotModel, dynamics: RobotDynamics) -> None:
    assert not lean(robot, dynamics, {}, WALL).any()
    assert not lean(robot, dynamics, {"right_hand": HandTarget(np.ones(3))}, WALL).any()
    assert not lean(robot, dynamics, PRESSING, WALL, yields=True).any()


def test_it_leans_against_both_palms_as_seen_from_the_ground_between_the_feet(
    robot: RobotModel, dynamics: RobotDynamics
) -> None:
    bracing, place, ground = Bracing(robot.mass, dynamics, DT), np.array([0.5, -0.2]), 0.1
    forces = {"left_arm": np.array([-20.0, 5.0, 10.0]), "right_arm": np.array([-40.0, 0.0, 0.0])}
    moment = np.zeros(2)
    for side in SIDES:
        palm, force = dynamics.palm(side), forces[f"{side}_arm"]
        moment += (palm[:2] - place) * force[2] - (palm[2] - ground) * force[:2]
    targets = {f"{side}_hand": HandTarget(np.ones(3), press=40.0) for side in SIDES}
    for _ in range(1000):
        bracing.update(targets, forces, (), place, ground)
    np.testing.assert_allclose(bracing.lean, moment / (robot.mass * GRAVITY), atol=1e-6)
    bracing.reset()
    assert not bracing.lean.any()
