"""What skills ask of hands and arms, and where parts of the body are."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from humanoid_bt.core.clock import CycleClock
from humanoid_bt.core.errors import HumanoidBtError
from humanoid_bt.core.geometry import rotation_matrix
from humanoid_bt.core.messages import ArmTarget, HandTarget, Pointing
from humanoid_bt.decision.arguments import check_relative
from humanoid_bt.decision.robot import Robot
from humanoid_bt.decision.robot_handle import RobotHandle
from humanoid_bt.robot.config import load_robot_config
from humanoid_bt.robot.model import RobotModel
from humanoid_bt.testing.rig import Rig

FILE = Path(__file__).resolve().parents[2] / "sim" / "humanoid" / "robot.yaml"
HANDS = ("left_hand", "right_hand")
PLACE = (0.4, 0.1, 0.9)


@pytest.fixture(scope="module")
def model() -> RobotModel:
    return RobotModel(load_robot_config(FILE))


@pytest.fixture(scope="module")
def standing() -> Rig:
    """A real robot, which stands turned and away from the origin."""
    rig = Rig()
    rig.run("turn", angle=0.5)
    return rig


@pytest.fixture
def robot(model: RobotModel, standing: Rig) -> Robot:
    robot = Robot(model.config, CycleClock(), model=model)
    robot.begin_tick(standing.state, {})
    return robot


@pytest.fixture
def handle(robot: Robot) -> RobotHandle:
    return RobotHandle(robot, "root/act", HANDS)


# ---- hands ----------------------------------------------------------------------------------------------------------


def hand(handle: RobotHandle) -> HandTarget:
    target = handle.targets["left_hand"]
    assert isinstance(target, HandTarget)
    return target


def test_a_place_alone_asks_for_nothing_else(handle: RobotHandle) -> None:
    handle.move_hand("left", PLACE)
    target = hand(handle)
    assert (target.orientation, target.relative, target.speed) == (None, False, None)


def test_an_orientation_is_a_quaternion_or_a_rotation_matrix(handle: RobotHandle) -> None:
    quaternion = np.array([0.5, 0.5, -0.5, 0.5])
    for given in (quaternion, list(quaternion * 1.004), rotation_matrix(quaternion)):
        handle.move_hand("left", PLACE, given, speed=0.2)
        found = hand(handle).orientation
        assert isinstance(found, np.ndarray)
        np.testing.assert_allclose(found, quaternion, atol=1e-12)
        assert not found.flags.writeable
    assert hand(handle).speed == 0.2


@pytest.mark.parametrize("length", [5, 1e-200, 1e200])
def test_a_direction_may_have_any_length(handle: RobotHandle, length: float) -> None:
    handle.move_hand("left", PLACE, direction=(0, 0, -length), axis="facing")
    found = hand(handle).orientation
    assert isinstance(found, Pointing)
    assert (found.axis, found.direction.tolist()) == ("facing", [0, 0, -1])


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        ({"orientation": (1, 0, 0, math.nan)}, "orientation must be finite"),
        ({"orientation": (1, 1, 0, 0)}, "no unit quaternion"),
        ({"orientation": (1, 0, 0)}, r"orientation must have shape \(4,\), w x y z, or \(3, 3\), not \(3,\)"),
        ({"orientation": "down"}, r"orientation must be numbers, shape \(4,\) or \(3, 3\), not 'down'"),
        ({"orientation": np.diag([1, 1, -1])}, "no rotation matrix"),
        ({"direction": (0, 0, 0)}, "direction must not be zero"),
        ({"direction": (1, math.inf, 0)}, "direction must be finite"),
        ({"direction": (1, 0)}, r"direction must have shape \(3,\)"),
        ({"direction": (1, 0, 0), "axis": "thumb"}, "'fingers' or 'facing', not 'thumb'"),
        ({"axis": "thumb"}, "'fingers' or 'facing', not 'thumb'"),
        ({"direction": (1, 0, 0), "orientation": (1, 0, 0, 0)}, "not both"),
        ({"speed": 0}, "speed of a motion must be above 0, not 0"),
        ({"speed": math.nan}, "above 0, not nan"),
        ({"speed": "fast"}, r"the speed of a motion must be a number \[m/s or rad/s\], not 'fast'"),
    ],
)
def test_what_is_no_target_of_a_hand_is_answered_at_once(handle: RobotHandle, asked: dict[str, Any], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        handle.move_hand("left", PLACE, **asked)
    assert not handle.targets


def test_what_is_no_side_is_answered_at_once(handle: RobotHandle) -> None:
    asked: list[Callable[[Any], Any]] = [
        lambda side: handle.move_hand(side, PLACE),
        lambda side: handle.move_arm(side, {}),
        handle.arm_joints,
        handle.arm_length,
        handle.touched,
    ]
    for ask in asked:
        with pytest.raises(ValueError, match="a side is 'left' or 'right', not 'middle'"):
            ask("middle")


def test_what_is_no_angle_and_no_name_is_answered_at_once(handle: RobotHandle) -> None:
    with pytest.raises(ValueError, match=r"an angle must be a number \[rad\], not 'far'"):
        handle.why_not_turned("left", "far")  # type: ignore[arg-type]  # as a skill without types does
    with pytest.raises(HumanoidBtError, match="the robot has no body or site None; "):
        handle.pose(None)  # type: ignore[arg-type]  # as a skill without types does


def test_what_is_told_has_one_of_three_levels(handle: RobotHandle) -> None:
    with pytest.raises(ValueError, match="an 'info', a 'warning' or an 'error', not 'loud'"):
        handle.log("text", "loud")  # type: ignore[arg-type]  # as a skill without types does


def test_a_hand_goes_only_with_one_that_has_a_place(robot: Robot, handle: RobotHandle) -> None:
    handle.move_hand("right", (0, 0, 0.2), relative=True)
    with pytest.raises(HumanoidBtError, match="it moves the right hand relative to the left one, which it does not"):
        check_relative(handle.targets)
    handle.move_hand("left", PLACE)
    check_relative(handle.targets)
    target = robot.commit().targets["right_hand"]
    assert isinstance(target, HandTarget) and target.relative


# ---- arms -----------------------------------------------------------------------------------------------------------


def test_joints_of_an_arm_take_the_place_of_its_hand(robot: Robot, handle: RobotHandle) -> None:
    handle.move_hand("right", PLACE)
    handle.move_arm("right", {"right_elbow": -1.2}, speed=0.5)
    assert robot.commit().targets == {"right_hand": ArmTarget({"right_elbow": -1.2}, 0.5)}


@pytest.mark.parametrize(
    ("joints", "why"),
    [
        ({"right_elbow": 1.2}, r"asks 1.2 rad of 'right_elbow', whose limits are -2.28 to -0.02 rad"),
        ({"right_elbow": math.nan}, "not finite: nan rad of 'right_elbow'"),
        ({"left_elbow": -1.0}, "names 'left_elbow', a joint of the left arm"),
        ({"right_elbo": -1.0}, "did you mean 'right_elbow'?"),
        ({"right_knee": 0.5}, "which is no joint of the right arm"),
        ({}, "names no joint"),
    ],
)
def test_what_is_no_target_of_an_arm_is_answered_at_once(
    handle: RobotHandle, joints: dict[str, float], why: str
) -> None:
    with pytest.raises(HumanoidBtError, match=why):
        handle.move_arm("right", joints)
    assert not handle.targets


def test_an_arm_is_commanded_by_who_declared_its_hand(robot: Robot) -> None:
    with pytest.raises(HumanoidBtError, match="commands 'right_hand' without declaring it"):
        RobotHandle(robot, "root/look", ("gaze",)).move_arm("right", {"right_elbow": -1.0})


def test_joints_of_an_arm_are_told_with_their_limits(handle: RobotHandle, model: RobotModel) -> None:
    joints = handle.arm_joints("left")
    elbow = joints["left_elbow"]
    assert len(joints) == 7
    assert (elbow.lower, elbow.upper) == pytest.approx((-2.28, -0.02))
    assert elbow.angle == handle.state.joint_positions[model.joint("left_elbow")]
    assert handle.arm_length("left") == pytest.approx(0.24 + 0.22 + 0.10)


# ---- poses ----------------------------------------------------------------------------------------------------------


def test_poses_are_those_of_the_state(handle: RobotHandle, model: RobotModel) -> None:
    state = handle.state
    assert state.stance[2] > 0.3
    base = handle.pose(model.config.base)
    np.testing.assert_allclose(base.position, state.base_position, atol=1e-12)
    np.testing.assert_allclose(base.quaternion, state.base_quaternion, atol=1e-9)
    np.testing.assert_allclose(base.rotation, rotation_matrix(state.base_quaternion), atol=1e-9)
    np.testing.assert_allclose(handle.pose("right_palm").position, state.hands["right"])
    np.testing.assert_allclose(handle.pose("gaze").position, state.gaze_position, atol=1e-9)
    foot = state.feet["left"]
    np.testing.assert_allclose(handle.pose("left_sole").position, [foot.x, foot.y, foot.z], atol=1e-9)
    elbow, wrist = handle.pose("left_forearm"), handle.pose("left_wrist_yaw_link")
    assert np.linalg.norm(wrist.position - elbow.position) == pytest.approx(0.22)


def test_a_palms_frame_has_its_fingers_along_x(handle: RobotHandle) -> None:
    body, palm = handle.pose("left_hand"), handle.pose("left_palm")
    np.testing.assert_allclose(palm.rotation[:, 0], -body.rotation[:, 2], atol=1e-9)
    np.testing.assert_allclose(palm.rotation[:, 2], -body.rotation[:, 1], atol=1e-9)


def test_the_shoulder_is_where_the_arm_begins(handle: RobotHandle) -> None:
    shoulder, first = handle.pose("right_shoulder"), handle.pose("right_shoulder_pitch_link")
    np.testing.assert_array_equal(shoulder.position, first.position)


def test_a_pose_stays_what_it_was(robot: Robot, handle: RobotHandle, standing: Rig) -> None:
    pose = handle.pose("head")
    before = pose.position.copy()
    standing.run("turn", angle=0.3, timeout=2)
    robot.begin_tick(standing.state, {})
    assert np.linalg.norm(handle.pose("head").position - before) > 1e-4
    np.testing.assert_array_equal(pose.position, before)
    with pytest.raises(ValueError, match="read-only"):
        pose.position[0] = 1.0


def test_a_name_that_is_none_is_answered_with_near_ones(handle: RobotHandle) -> None:
    with pytest.raises(HumanoidBtError, match="no body or site 'right_shouldr'; near it: right_shoulder, ") as caught:
        handle.pose("right_shouldr")
    assert "right_shoulder_roll_link" in str(caught.value)
    with pytest.raises(HumanoidBtError, match="near it: left_wrist_yaw_link, left_wrist_pitch_link"):
        handle.pose("left_wrist")


def test_a_robot_whose_model_was_not_given_makes_it(standing: Rig) -> None:
    robot = Robot(load_robot_config(FILE), CycleClock())
    robot.begin_tick(standing.state, {})
    palm = RobotHandle(robot, "a", ()).pose("left_palm")
    np.testing.assert_array_equal(palm.position, standing.state.hands["left"])
