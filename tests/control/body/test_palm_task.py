"""The task of a palm that is turned, or held relative to the other one: its rows are the derivatives of its errors."""

from __future__ import annotations

import mink
import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.palm_task import PalmTask
from humanoid_bt.core.geometry import quaternion, rotation_matrix, turned
from humanoid_bt.core.messages import Array, HandTarget, PalmAxis, Pointing
from humanoid_bt.core.palm import in_world, turn_left
from humanoid_bt.robot.model import RobotModel, palm_site
from tests.control.body.pose import Pose

SMALL = 1e-6
ASIDE = np.array([0.02, -0.03, 0.01])


def data_at(robot: RobotModel, qpos: Array) -> mujoco.MjData:
    data = mujoco.MjData(robot.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(robot.model, data)
    mujoco.mj_comPos(robot.model, data)
    return data


def frame(robot: RobotModel, qpos: Array, side: str) -> Array:
    return Pose(robot, qpos).rotation(palm_site(side)) @ robot.palm_axes[side]  # type: ignore[index]  # this robot has palms


def near(robot: RobotModel, qpos: Array, relative: bool, axis: PalmAxis | None) -> HandTarget:
    """Return a goal near where the right palm is."""
    pose = Pose(robot, qpos)
    turn, place = frame(robot, qpos, "right"), pose.site(palm_site("right"))
    if relative:
        leader = frame(robot, qpos, "left")
        turn, place = leader.T @ turn, leader.T @ (place - pose.site(palm_site("left")))
    goal = turned(quaternion(turn), ASIDE)
    if axis is None:
        return HandTarget(place + ASIDE, goal, relative)
    column = 0 if axis == "fingers" else 2
    return HandTarget(place + ASIDE, Pointing(rotation_matrix(goal)[:, column], axis), relative)


@pytest.mark.parametrize("relative", [False, True])
@pytest.mark.parametrize("axis", [None, "fingers", "facing"])
def test_the_jacobian_is_the_errors_derivative(
    robot: RobotModel, standing: Array, relative: bool, axis: PalmAxis | None
) -> None:
    """Of orientations to first order in the error: that is a few hundredths here."""
    goal, task = near(robot, standing, relative, axis), PalmTask(robot, robot.model, "right")
    task.aim(data_at(robot, standing), goal)
    jacobian, error = task.jacobian.copy(), task.error.copy()
    assert np.linalg.norm(error[:3]) == pytest.approx(np.linalg.norm(ASIDE))
    assert 0.01 < np.linalg.norm(error[3:]) <= np.linalg.norm(ASIDE) + 1e-9
    for dof in range(robot.model.nv):
        moved = standing.copy()
        mujoco.mj_integratePos(robot.model, moved, np.eye(robot.model.nv)[dof], SMALL)
        task.aim(data_at(robot, moved), goal)
        np.testing.assert_allclose((error - task.error) / SMALL, jacobian[:, dof], atol=0.06)


def test_the_trunk_has_no_part_in_how_palms_are_to_each_other(robot: RobotModel, standing: Array) -> None:
    task = PalmTask(robot, robot.model, "right")
    goal = near(robot, standing, relative=True, axis=None)
    turned_away = HandTarget(goal.position - ASIDE, goal.orientation, relative=True)
    task.aim(data_at(robot, standing), turned_away)
    arms = [6 + joint for side in ("left", "right") for joint in robot.arm_joints(side)]  # type: ignore[arg-type]  # this robot has arms
    others = np.setdiff1d(np.arange(robot.model.nv), arms)
    np.testing.assert_allclose(task.jacobian[:, others], 0, atol=1e-12)
    assert np.abs(task.jacobian[:, arms]).max() > 0.1


def test_without_an_orientation_only_the_place_counts(robot: RobotModel, standing: Array) -> None:
    task = PalmTask(robot, robot.model, "right")
    goal = near(robot, standing, relative=True, axis=None)
    task.aim(data_at(robot, standing), goal)
    assert task.cost[3:].min() > 0
    task.aim(data_at(robot, standing), HandTarget(goal.position, None, relative=True))
    np.testing.assert_array_equal(task.cost[3:], 0)


def test_its_residual_and_its_objective_are_one_problem(robot: RobotModel, standing: Array) -> None:
    task, configuration = PalmTask(robot, robot.model, "right"), mink.Configuration(robot.model)
    task.aim(data_at(robot, standing), near(robot, standing, relative=False, axis=None))
    jacobian, error, damping = task.compute_qp_residual(configuration)
    objective = task.compute_qp_objective(configuration)
    np.testing.assert_allclose(objective.H, jacobian.T @ jacobian + damping * np.eye(robot.model.nv))
    np.testing.assert_allclose(objective.c, -(error @ jacobian))


def test_a_goal_relative_to_a_palm_has_a_place_in_the_world(robot: RobotModel, standing: Array) -> None:
    pose, leader = Pose(robot, standing), frame(robot, standing, "left")
    goal = in_world(near(robot, standing, True, None), pose.site(palm_site("left")), leader)
    np.testing.assert_allclose(goal.position, pose.site(palm_site("right")) + leader @ ASIDE, atol=1e-12)
    assert goal.orientation is not None
    assert turn_left(frame(robot, standing, "right"), goal.orientation) == pytest.approx(np.linalg.norm(ASIDE))
