"""Angles of an arm for a palm that is turned: found from anywhere, inside of all limits, own links apart."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np
import pytest

from humanoid_bt.control.body.arm_search import ArmSearch
from humanoid_bt.control.body.self_collision import SelfCollisionLimit
from humanoid_bt.core.geometry import quaternion
from humanoid_bt.core.messages import Array, HandTarget, Pointing, Side
from humanoid_bt.core.palm import turn_left
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel, palm_site
from tests.joint_ranges import write_joint_ranges

LEFT: Side = "left"
OUT_OF_REACH = HandTarget(np.array([3.0, 0.0, 1.0]), Pointing(np.array([1.0, 0.0, 0.0])))


@pytest.fixture(scope="module")
def links(robot: RobotModel) -> SelfCollisionLimit:
    return SelfCollisionLimit(robot)


@pytest.fixture
def search(robot: RobotModel, links: SelfCollisionLimit) -> ArmSearch:
    return ArmSearch(robot, links, LEFT)


def palm(robot: RobotModel, qpos: Array) -> tuple[Array, Array]:
    """Return place and frame of the left palm in a configuration."""
    data = mujoco.MjData(robot.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(robot.model, data)
    site = data.site(palm_site(LEFT))
    return site.xpos.copy(), site.xmat.reshape(3, 3) @ robot.palm_axes[LEFT]


def with_arm(robot: RobotModel, qpos: Array, angles: Array) -> Array:
    bent = qpos.copy()
    bent[np.add(robot.arm_joints(LEFT), 7)] = angles
    return bent


def drawn(robot: RobotModel, links: SelfCollisionLimit, standing: Array, seed: int) -> Array:
    """Return a configuration with angles of the left arm that it can have."""
    numbers, arm = np.random.default_rng(seed), robot.arm_joints(LEFT)
    while True:
        qpos = with_arm(robot, standing, numbers.uniform(robot.lower[arm] + 0.05, robot.upper[arm] - 0.05))
        if are_apart(links, qpos):
            return qpos


def are_apart(links: SelfCollisionLimit, qpos: Array) -> bool:
    data = mujoco.MjData(links.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(links.model, data)
    mujoco.mj_comPos(links.model, data)
    return links.are_apart(data, range(links.model.nbody))


def all_of(search: ArmSearch) -> list[Array]:
    found = []
    while not search.over:
        if (angles := search.go_on(1)) is not None:
            found.append(angles)
    return found


@pytest.mark.parametrize("seed", range(10))
def test_finds_angles_for_a_pose_that_the_arm_can_have(
    robot: RobotModel, links: SelfCollisionLimit, search: ArmSearch, standing: Array, seed: int
) -> None:
    place, frame = palm(robot, drawn(robot, links, standing, seed))
    goal = HandTarget(place, quaternion(frame))
    search.begin(standing, goal)
    angles = search.go_on(2000)
    assert angles is not None
    arm = robot.arm_joints(LEFT)
    assert (angles >= robot.lower[arm]).all()
    assert (angles <= robot.upper[arm]).all()
    there, turn = palm(robot, with_arm(robot, standing, angles))
    assert np.linalg.norm(there - place) < 0.005
    assert turn_left(turn, goal.orientation) < 0.02  # type: ignore[arg-type]  # the goal has one


def test_says_when_there_are_none(search: ArmSearch, standing: Array) -> None:
    search.begin(standing, OUT_OF_REACH)
    assert all_of(search) == []
    assert search.go_on(1) is None


def test_comes_as_near_as_it_can_where_the_body_can_do_the_rest(
    search: ArmSearch, robot: RobotModel, links: SelfCollisionLimit, standing: Array
) -> None:
    far = HandTarget(np.array([0.55, 0.2, 0.95]))
    search.begin(standing, far)
    assert all_of(search) == []
    nearest = search.go_on(1)
    assert nearest is not None
    there, _ = palm(robot, with_arm(robot, standing, nearest))
    assert np.linalg.norm(there - far.position) < 0.25
    assert are_apart(links, with_arm(robot, standing, nearest))
    assert search.go_on(1) is None  # it was told already
    search.begin(standing, far)
    all_of(search)
    search.begin(standing, OUT_OF_REACH)  # for which that is none
    assert all_of(search) == []
    assert search.go_on(1) is None


def test_finds_no_angles_at_which_own_links_meet(
    search: ArmSearch, robot: RobotModel, links: SelfCollisionLimit, standing: Array
) -> None:
    search.begin(standing, HandTarget(np.array([0.2, 0.0, 0.9])))  # close to the trunk
    found = all_of(search)
    assert found
    assert all(are_apart(links, with_arm(robot, standing, angles)) for angles in found)


def test_an_arm_without_limits_is_searched_within_a_turn(endless: RobotModel, standing: Array) -> None:
    search, spun = ArmSearch(endless, SelfCollisionLimit(endless), LEFT), standing.copy()
    spun[7 + endless.joint("left_wrist_yaw")] += 6.0
    place, frame = palm(endless, standing)
    search.begin(spun, HandTarget(place, quaternion(frame)))
    found = all_of(search)
    assert len(found) > 1
    for angles in found:
        there, _ = palm(endless, with_arm(endless, standing, angles))
        assert np.linalg.norm(there - place) < 0.005


def test_a_joint_that_hardly_turns_stays_within_its_limits(tmp_path: Path, standing: Array) -> None:
    robot = RobotModel(load_robot_config(write_joint_ranges(tmp_path, "left_wrist_roll", half=0.01)))
    search, wrist = ArmSearch(robot, SelfCollisionLimit(robot), LEFT), robot.joint("left_wrist_roll")
    place, frame = palm(robot, standing)
    search.begin(standing, HandTarget(place, quaternion(frame)))
    found = all_of(search)
    assert len(found) > 1
    for angles in found:
        assert robot.lower[wrist] <= angles[robot.arm_joints(LEFT).index(wrist)] <= robot.upper[wrist]


def test_does_the_same_again(search: ArmSearch, robot: RobotModel, links: SelfCollisionLimit, standing: Array) -> None:
    place, frame = palm(robot, drawn(robot, links, standing, 1))
    found = []
    for _ in range(2):
        search.begin(standing, HandTarget(place, quaternion(frame)))
        found.append(all_of(search))
    assert len(found[0]) > 1
    assert all(np.array_equal(one, other) for one, other in zip(*found, strict=True))
