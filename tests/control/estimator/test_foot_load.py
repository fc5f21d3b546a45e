"""What the feet carry, from the torques of the legs."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.dynamics import GRAVITY, RobotDynamics
from humanoid_bt.control.estimator.foot_load import FootLoad
from humanoid_bt.core.messages import SIDES, Estimate
from humanoid_bt.robot.model import BASE_COORDINATES, BASE_DOFS, RobotModel, sole_site

_OFF = 10.0  # Nm, of a joint's torque


@pytest.mark.parametrize("bent", [0.5, 0.02], ids=["bent", "stretched"])
def test_no_leg_pulls_while_nothing_carries_the_robot(robot: RobotModel, bent: float) -> None:
    """A stretched leg says little of forces along it: torques that are off may say that it pulls."""
    dynamics = RobotDynamics(robot)
    qpos = robot.home_qpos.copy()
    for side in SIDES:
        for name, angle in (("hip_pitch", -bent / 2), ("knee", bent), ("ankle_pitch", -bent / 2)):
            qpos[BASE_COORDINATES + robot.joint(f"{side}_{name}")] = angle
    joints = len(robot.joint_names)
    at_rest = np.zeros(BASE_DOFS + joints)
    dynamics.update(Estimate(0.0, qpos, at_rest, np.zeros(joints), np.zeros(2)))
    weight, torque = robot.mass * GRAVITY, dynamics.bias.copy()
    jacobian = np.zeros((3, len(torque)))
    mujoco.mj_jacSite(dynamics.model, dynamics.data, jacobian, None, robot.model.site(sole_site("left")).id)
    torque -= weight * jacobian[2]
    for seed in range(100):
        load = FootLoad(robot, dynamics)
        off = np.random.default_rng(seed).uniform(-_OFF, _OFF, joints)
        load.explain(at_rest, at_rest, torque[BASE_DOFS:] + off, 0.0)
        assert load.standing[0] or load.standing[1] or load.force.min() > -0.1 * weight


@pytest.fixture
def home(robot: RobotModel) -> RobotDynamics:
    """The humanoid at rest at home."""
    dynamics, joints = RobotDynamics(robot), len(robot.joint_names)
    dynamics.update(Estimate(0.0, robot.home_qpos, np.zeros(BASE_DOFS + joints), np.zeros(joints), np.zeros(2)))
    return dynamics


def test_a_robot_that_people_hold_does_not_stand(robot: RobotModel, home: RobotDynamics) -> None:
    load, at_rest = FootLoad(robot, home), np.zeros(len(home.bias))
    load.explain(at_rest, at_rest, home.bias[BASE_DOFS:].copy(), 0.0)
    np.testing.assert_allclose(load.force, 0.0, atol=1e-6)
    assert load.standing == [False, False]


def test_a_robot_that_falls_freely_is_carried_by_nothing(robot: RobotModel, home: RobotDynamics) -> None:
    load, at_rest, falls = FootLoad(robot, home), np.zeros(len(home.bias)), np.zeros(len(home.bias))
    falls[2] = -GRAVITY
    jacobian, pull = np.zeros((3, len(falls))), 0.2 * robot.mass * GRAVITY
    mujoco.mj_jacSite(home.model, home.data, jacobian, None, robot.model.site(sole_site("left")).id)
    load.explain(at_rest, falls, pull * jacobian[2, BASE_DOFS:], -GRAVITY)
    np.testing.assert_allclose(load.force, [-pull, 0.0], atol=0.1 * pull)
    assert load.standing == [False, False]


def test_a_foot_stands_from_more_than_what_it_stands_up_to(robot: RobotModel, home: RobotDynamics) -> None:
    load, weight = FootLoad(robot, home), robot.mass * GRAVITY
    for share, stands in ((0.5, True), (0.1, True), (0.05, False), (0.1, False), (0.2, True)):
        load.sensed(np.array([share, 1.0 - share]) * weight)
        assert load.standing == [stands, True]
    load.sensed(np.zeros(2))
    load.reset()
    assert load.standing == [True, True]
    np.testing.assert_allclose(load.force, weight / 2)


@pytest.mark.parametrize("right", [0.5, 0.05], ids=["it is carried by the other one", "nothing else carries it"])
def test_what_no_leg_says_that_it_carries_is_given_to_them_and_nothing_where_one_says_it(
    robot: RobotModel, home: RobotDynamics, right: float
) -> None:
    load, at_rest, weight = FootLoad(robot, home), np.zeros(len(home.bias)), robot.mass * GRAVITY
    shares, torque = (-0.2, right), home.bias[BASE_DOFS:].copy()
    jacobian = np.zeros((3, len(at_rest)))
    for side, share in zip(SIDES, shares, strict=True):
        mujoco.mj_jacSite(home.model, home.data, jacobian, None, robot.model.site(sole_site(side)).id)
        torque -= share * weight * jacobian[2, BASE_DOFS:]
    load.explain(at_rest, at_rest, torque, 0.0)
    if right < 0.1:
        given = load.force - np.array(shares) * weight
        assert given[0] == pytest.approx(given[1], rel=0.05)  # as the legs are alike
        assert 0.2 * weight < given[0] < 0.6 * weight
    else:
        np.testing.assert_allclose(load.force, np.array(shares) * weight, atol=0.03 * weight)
