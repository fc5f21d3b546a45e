"""The task of the whole body: its rows are the derivatives of its errors."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import mink
import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.body_task import BodyTargets, BodyTask
from humanoid_bt.control.body.standing import standing_posture
from humanoid_bt.core.messages import SIDES, Array
from humanoid_bt.robot.model import BASE_COORDINATES, RobotModel, sole_site

SMALL = 1e-6


@pytest.fixture
def targets(robot: RobotModel, standing: Array) -> BodyTargets:
    """Somewhere near, and turned a little."""
    half = robot.config.gait.stance_width / 2
    return BodyTargets(
        com=np.array([0.02, -0.01, 0.6]),
        soles={"left": np.array([0.02, half, 0.01]), "right": np.array([0, -half, 0.02])},
        sole_footings={"left": np.array([0.01, 0.02, -0.03]), "right": np.zeros(3)},
        sole_corrections={"left": np.array([0, 0, 0, 0.01, 0.02, 0]), "right": np.zeros(6)},
        heading=0.02,
        torso_yaw=0.01,
        lean=(0.01, 0.02),
        gaze=(0.02, 0.01),
        hands={},
        reaching=0.5,
        posture=standing[BASE_COORDINATES:] + 0.01,
    )


def with_spin(robot: RobotModel, cost: float) -> RobotModel:
    """Return a robot to which it costs so much to spin."""
    spinning = copy(robot)
    spinning.config = replace(robot.config, whole_body=replace(robot.config.whole_body, spin=cost))
    return spinning


def data_at(robot: RobotModel, qpos: Array) -> mujoco.MjData:
    data = mujoco.MjData(robot.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(robot.model, data)
    mujoco.mj_comPos(robot.model, data)
    return data


def test_the_jacobian_is_the_errors_derivative(robot: RobotModel, standing: Array, targets: BodyTargets) -> None:
    """Of orientations to first order in the error: that is a few hundredths here."""
    task = BodyTask(with_spin(robot, 0.0), robot.model)
    task.aim(data_at(robot, standing), targets)
    jacobian, error = task.jacobian.copy(), task.error.copy()
    assert np.abs(error).max() > 0.01
    for dof in range(robot.model.nv):
        moved = standing.copy()
        mujoco.mj_integratePos(robot.model, moved, np.eye(robot.model.nv)[dof], SMALL)
        task.aim(data_at(robot, moved), targets)
        np.testing.assert_allclose((error - task.error) / SMALL, jacobian[:, dof], atol=0.05)


def test_it_tilts_pelvis_and_torso_about_the_axes_of_the_heading(
    robot: RobotModel, standing: Array, targets: BodyTargets
) -> None:
    task, tilt = BodyTask(robot, robot.model), np.array([0.10, -0.05, 0.20, 0.15])
    for heading, about in ((0.0, tilt), (np.pi / 2, tilt[[1, 0, 3, 2]] * [-1, 1, -1, 1])):  # seen from the world
        turned = standing.copy()
        turned[3:7] = np.cos(heading / 2), 0.0, 0.0, np.sin(heading / 2)
        data, upright = data_at(robot, turned), replace(targets, heading=heading, torso_yaw=0.0, lean=(0.0, 0.0))
        task.aim(data, upright)
        before = task.error[15:21].copy()
        task.aim(data, replace(upright, tilt=tuple(tilt.tolist())))
        pelvis, torso = (task.error[15:21] - before).reshape(2, 3)
        np.testing.assert_allclose(pelvis, [*about[:2], 0.0], atol=1e-3)
        np.testing.assert_allclose(torso, [*about[2:], 0.0], atol=5e-3)


def test_its_residual_and_its_objective_are_one_problem(
    robot: RobotModel, standing: Array, targets: BodyTargets
) -> None:
    task = BodyTask(robot, robot.model)
    task.aim(data_at(robot, standing), targets)
    configuration = mink.Configuration(robot.model, standing)
    jacobian, error, damping = task.compute_qp_residual(configuration)
    objective = task.compute_qp_objective(configuration)
    assert damping > 0
    np.testing.assert_allclose(objective.H, jacobian.T @ jacobian + damping * np.eye(robot.model.nv), atol=1e-9)
    np.testing.assert_allclose(objective.c, -jacobian.T @ error, atol=1e-9)


def test_height_and_turns_of_a_body_are_firm_each_by_its_own_factor(
    robot: RobotModel, standing: Array, targets: BodyTargets
) -> None:
    task, data = BodyTask(robot, robot.model), data_at(robot, standing)
    task.aim(data, targets)
    before = task.cost.copy()
    task.aim(data, replace(targets, firmness=(5.0, 2.0)))
    factors = np.divide(task.cost, before, out=np.ones_like(before), where=before > 0)
    assert factors[2] == pytest.approx(5.0)  # the height of the centre of mass
    np.testing.assert_allclose(factors[15:21], 2.0)  # pelvis and torso
    np.testing.assert_allclose(np.delete(factors, [2, *range(15, 21)]), 1.0)


def test_a_foot_in_the_air_costs_less_but_for_its_height(
    robot: RobotModel, standing: Array, targets: BodyTargets
) -> None:
    """Lifted less, it would stumble."""
    task, data = BodyTask(robot, robot.model), data_at(robot, standing)
    task.aim(data, targets)
    grounded = task.cost.copy()
    for side, sole in (("left", 3), ("right", 9)):
        task.aim(data, replace(targets, swings=side))
        cheaper = np.flatnonzero(task.cost < grounded)
        np.testing.assert_array_equal(cheaper, [sole, sole + 1, sole + 3, sole + 4, sole + 5])
        np.testing.assert_array_equal(np.delete(task.cost, cheaper), np.delete(grounded, cheaper))
    task.aim(data, targets)
    np.testing.assert_array_equal(task.cost, grounded)


def test_it_keeps_from_spinning_if_that_costs_something(
    robot: RobotModel, standing: Array, targets: BodyTargets
) -> None:
    """The last row gives the angular momentum about the vertical, as physics has it."""
    task, plain = (BodyTask(with_spin(robot, cost), robot.model) for cost in (4.0, 0.0))
    data = data_at(robot, standing)
    task.aim(data, targets)
    plain.aim(data, targets)
    np.testing.assert_array_equal(task.jacobian[:-1], plain.jacobian)
    np.testing.assert_array_equal(task.cost, [*plain.cost, 4.0])
    assert task.error[-1] == 0.0
    data.qvel[:] = np.linspace(-1, 1, robot.model.nv)
    mujoco.mj_comVel(robot.model, data)
    mujoco.mj_subtreeVel(robot.model, data)
    assert task.jacobian[-1] @ data.qvel == pytest.approx(data.subtree_angmom[1][2])


def test_its_momenta_are_mujocos(robot: RobotModel, standing: Array, targets: BodyTargets) -> None:
    task, data = BodyTask(with_spin(robot, 4.0), robot.model), data_at(robot, standing)
    task.aim(data, targets)
    com, spin = np.zeros((2, 3, robot.model.nv))
    mujoco.mj_jacSubtreeCom(robot.model, data, com, 1)
    mujoco.mj_angmomMat(robot.model, data, spin, 1)
    np.testing.assert_allclose(task.jacobian[:3], com, atol=1e-12)
    np.testing.assert_allclose(task.jacobian[-1], spin[2], atol=1e-12)


def test_it_turns_the_short_way(robot: RobotModel, standing: Array, targets: BodyTargets) -> None:
    """Quaternions have two signs."""
    task = BodyTask(robot, robot.model)
    task.aim(data_at(robot, standing), replace(targets, heading=2 * np.pi - 0.1, torso_yaw=0.0, gaze=(0.0, 0.0)))
    assert np.abs(task.error).max() < 0.7


@pytest.fixture
def line_targets(line_feet: RobotModel) -> BodyTargets:
    """Where feet stand that no joint rolls, and near that."""
    standing = standing_posture(line_feet)
    data = data_at(line_feet, standing)
    soles = {side: data.site(sole_site(side)).xpos for side in SIDES}
    return BodyTargets(
        com=data.subtree_com[1] + 0.01,
        soles={side: np.array([*sole[:2], 0.0]) for side, sole in soles.items()},
        sole_footings={side: np.array([sole[2], 0.0, 0.0]) for side, sole in soles.items()},
        sole_corrections=dict.fromkeys(SIDES, np.zeros(6)),
        heading=0.02,
        torso_yaw=0.01,
        lean=(0.01, 0.02),
        gaze=(0.02, 0.01),
        hands={},
        reaching=0.0,
        posture=standing[BASE_COORDINATES:] + 0.01,
    )


def test_a_foot_that_no_joint_rolls_may_lean_sideways_and_in_no_other_way(
    line_feet: RobotModel, line_targets: BodyTargets
) -> None:
    task, data = BodyTask(line_feet, line_feet.model), data_at(line_feet, standing_posture(line_feet))
    height = line_targets.sole_footings["left"][0]

    def cost(roll: float, pitch: float) -> float:
        footings = dict.fromkeys(SIDES, np.array([height, roll, pitch]))
        task.aim(data, replace(line_targets, sole_footings=footings))
        feet = slice(3, 3 + 6 * len(SIDES))  # after the centre of mass: position and orientation of each
        return float(np.linalg.norm(task.cost[feet] * task.error[feet]))

    assert cost(0.0, 0.0) < 0.1
    assert cost(0.1, 0.0) < 0.1
    assert cost(0.0, 0.1) > 1.0


def test_the_jacobian_is_the_errors_derivative_where_feet_do_not_roll(
    line_feet: RobotModel, line_targets: BodyTargets
) -> None:
    """Of feet that point aside in the world: their own axes are none of its axes."""
    near = standing_posture(line_feet)
    near[BASE_COORDINATES:] += 0.01
    near[3:BASE_COORDINATES] = [np.cos(0.4), 0.0, 0.0, np.sin(0.4)]
    soles = {side: np.array([*sole[:2], 0.81]) for side, sole in line_targets.soles.items()}
    line_targets = replace(line_targets, soles=soles, heading=0.81, gaze=(0.01, 0.01))
    task = BodyTask(with_spin(line_feet, 0.0), line_feet.model)
    task.aim(data_at(line_feet, near), line_targets)
    jacobian, error = task.jacobian.copy(), task.error.copy()
    for dof in range(line_feet.model.nv):
        moved = near.copy()
        mujoco.mj_integratePos(line_feet.model, moved, np.eye(line_feet.model.nv)[dof], SMALL)
        task.aim(data_at(line_feet, moved), line_targets)
        np.testing.assert_allclose((error - task.error) / SMALL, jacobian[:, dof], atol=0.06)
